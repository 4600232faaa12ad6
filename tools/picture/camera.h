// Where a picture is taken from: an orthographic projection onto pixels.
#pragma once

#include <span>
#include <string>

#include "meshing/base/point.h"

namespace weft::picture {

/// The direction from the scene to the eye and the direction that is up in the picture; need not be unit
/// vectors.
struct View {
  meshing::Vec toward_eye;
  meshing::Vec up;
};

/// `x`, `-x`, `y`, `-y`, `z`, `-z`: the eye stands out on that axis; `iso`: on (1, -1, 1); or
/// `AZIMUTH,ELEVATION` in degrees, from the x axis towards y, and above the xy plane. Throws
/// std::invalid_argument for anything else.
meshing::Vec direction_named(const std::string& name);

/// z up, or y where the eye looks along z.
meshing::Vec default_up(const meshing::Vec& toward_eye);

/// A place on the picture, in pixels from its upper left corner; depth, in pixels too, grows away from the
/// eye.
struct Projected {
  double x = 0, y = 0, depth = 0;
};

class Camera {
 public:
  /// Fits the points' extents into `width` times `height` pixels less a margin of 3 %, enlarged by `zoom`.
  /// Without points, or with all at one place, the scale is arbitrary. Throws std::invalid_argument where
  /// the view's directions are parallel or zero.
  Camera(const View& view, std::span<const meshing::Point> points, double width, double height,
         double zoom = 1);

  Projected project(const meshing::Point& p) const;
  /// The picture's x and y (downwards) parts and the depth part of a direction, for the axes.
  Projected turn(const meshing::Vec& direction) const;
  /// Unit vector to the eye.
  const meshing::Vec& toward_eye() const { return toward_eye_; }
  /// Unit vector upwards in the picture.
  const meshing::Vec& up() const { return up_; }
  const meshing::Vec& right() const { return right_; }

 private:
  meshing::Vec right_, up_, toward_eye_;
  meshing::Point centre_;  ///< what lies in the picture's middle
  double scale_ = 1;       ///< pixels per unit of length
  double middle_x_ = 0, middle_y_ = 0;
};

}  // namespace weft::picture
