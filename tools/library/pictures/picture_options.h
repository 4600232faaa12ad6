// Option values of pictures: file names, sizes, planes and boxes as text.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "tools/picture/canvas.h"
#include "tools/picture/facet.h"

namespace weft::tools {

/// The format of such a name; PNG for any other.
picture::Canvas::Format picture_format(const std::string& name);

/// What a user typed, as a number of each kind. All of them throw std::invalid_argument saying what is wrong.

/// `count` finite numbers with commas between them.
std::vector<double> numbers_in(const std::string& text, std::size_t count);
/// WIDTHxHEIGHT, each from 16 to 16000.
std::pair<int, int> picture_size(const std::string& text);
/// X0,Y0,Z0,X1,Y1,Z1: two opposite corners, in any order.
meshing::Box box_in(const std::string& text);
/// `x=0.5` (or y, z), or PX,PY,PZ,NX,NY,NZ: a point and the direction of what is cut away. Of the two sides
/// of `x=0.5` the one towards the eye is.
picture::Plane plane_in(const std::string& text, const meshing::Vec& toward_eye);

}  // namespace weft::tools
