#include "tools/library/parts/part_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/fields/interpolate.h"
#include "partition/communication/agreement.h"

namespace weft::tools {
namespace {

using partition::Peers;

/// What every rank must know of the fields: names are the caller's and stay here.
struct FieldShape {
  std::uint64_t components;
};

/// All ranks: the components of each field, agreed upon; ranks without points need not list them.
std::vector<std::size_t> agree_on_shapes(Peers& peers, const Part& from) {
  std::vector<FieldShape> mine;
  for (const Field& field : from.fields.fields)
    mine.push_back({static_cast<std::uint64_t>(components(field.kind))});
  std::vector<std::size_t> shapes;
  bool known = false, differ = false;
  for (const auto& of_rank : partition::allgather(peers, mine)) {
    if (of_rank.empty()) continue;
    std::vector<std::size_t> these;
    for (const FieldShape& shape : of_rank) these.push_back(shape.components);
    differ |= known && these != shapes;
    shapes = std::move(these);
    known = true;
  }
  if (differ) throw InputError("", "fields", "are not of the same number and kinds on all ranks");
  return shapes;
}

/// The box of a part's tets; empty where there are none. Plain data.
struct RankBox {
  Point lo, hi;
  std::uint64_t tets;

  /// Squared distance of a point from it; none is infinitely far from no tets.
  double distance2(const Point& p) const {
    if (tets == 0) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::max({lo[axis] - p[axis], 0.0, p[axis] - hi[axis]});
      sum += d * d;
    }
    return sum;
  }
};

std::vector<RankBox> boxes_of_all(Peers& peers, const Part& from) {
  meshing::Box box;
  for (const auto& tet : from.mesh.tets)
    for (const std::uint32_t v : tet) box.include(from.mesh.points[v]);
  const RankBox mine{box.lo, box.hi, from.mesh.tets.size()};
  std::vector<RankBox> all;
  for (const auto& of_rank : partition::allgather(peers, std::vector<RankBox>{mine}))
    all.push_back(of_rank[0]);
  return all;
}

/// The best answer so far to one point: from the rank whose part is nearest, the lowest of equals.
struct Best {
  double distance2 = std::numeric_limits<double>::infinity();
  std::vector<double> values;
};

class Exchange {
 public:
  Exchange(Peers& peers, const Part& from, std::vector<std::size_t> shapes)
      : peers_(peers), from_(from), shapes_(std::move(shapes)) {
    for (const std::size_t n : shapes_) width_ += n;
    if (!from.mesh.tets.empty())
      background_.reset(new meshing::Background(meshing::field_background(from.mesh)));
  }

  /// All ranks: asks each rank r for the values at the points asked[r], and keeps what is nearer than before.
  void ask(const std::vector<std::vector<std::uint32_t>>& asked, const std::vector<Point>& points,
           std::vector<Best>& best) {
    std::vector<std::vector<Point>> questions(asked.size());
    for (std::size_t r = 0; r < asked.size(); ++r)
      for (const std::uint32_t v : asked[r]) questions[r].push_back(points[v]);
    questions = partition::all_to_all(peers_, questions);
    std::vector<std::vector<double>> answers(questions.size());
    for (std::size_t r = 0; r < questions.size(); ++r) answers[r] = answer(questions[r]);
    answers = partition::all_to_all(peers_, answers);
    for (std::size_t r = 0; r < asked.size(); ++r)
      for (std::size_t i = 0; i < asked[r].size(); ++i) {
        const double* told = answers[r].data() + i * (1 + width_);
        Best& mine = best[asked[r][i]];
        if (told[0] >= mine.distance2) continue;
        mine.distance2 = told[0];
        mine.values.assign(told + 1, told + 1 + width_);
      }
  }

 private:
  /// For each point its distance from this part, squared, and all values there.
  std::vector<double> answer(const std::vector<Point>& points) const {
    std::vector<double> told;
    told.reserve(points.size() * (1 + width_));
    std::uint32_t hint = meshing::Background::kNoHint;
    for (const Point& p : points) {
      const meshing::Background::Place place = background_->locate(p, hint);
      hint = place.tet;
      told.push_back(place.distance2);
      for (std::size_t f = 0; f < shapes_.size(); ++f)
        for (std::size_t c = 0; c < shapes_[f]; ++c) {
          double sum = 0;
          for (std::size_t i = 0; i < 4; ++i)
            if (place.at[i] > 0)
              sum +=
                  place.at[i] * from_.fields.fields[f].values[shapes_[f] * from_.mesh.tets[place.tet][i] + c];
          told.push_back(sum);
        }
    }
    return told;
  }

  Peers& peers_;
  const Part& from_;
  std::vector<std::size_t> shapes_;
  std::size_t width_ = 0;
  std::unique_ptr<const meshing::Background> background_;  ///< null: no tets here
};

Field::Kind kind_of(std::size_t components) {
  return components == 1 ? Field::Kind::scalar : components == 3 ? Field::Kind::vector : Field::Kind::tensor;
}

Fields fields_of(const std::vector<Best>& best, const std::vector<std::size_t>& shapes, const Fields& names) {
  Fields fields{best.size(), {}};
  std::size_t first = 0;
  for (std::size_t f = 0; f < shapes.size(); ++f) {
    Field field{kind_of(shapes[f]), {}, f < names.fields.size() ? names.fields[f].name : std::string()};
    field.values.reserve(best.size() * shapes[f]);
    for (const Best& b : best)
      for (std::size_t c = 0; c < shapes[f]; ++c) field.values.push_back(b.values[first + c]);
    first += shapes[f];
    fields.fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace

Fields interpolate_parts(Peers& peers, const Part& from, const Part& to) {
  const std::vector<std::size_t> shapes = agree_on_shapes(peers, from);
  if (shapes.empty()) return {};
  std::optional<Exchange> exchange;
  partition::agree_on(peers, [&] { exchange.emplace(peers, from, shapes); });
  const std::vector<RankBox> boxes = boxes_of_all(peers, from);
  const std::vector<Point>& points = to.mesh.points;
  std::vector<Best> best(points.size());
  // First whoever's box has the point, or is nearest; then whoever's box is nearer than what they have found.
  std::vector<std::vector<std::uint32_t>> asked(boxes.size());
  std::vector<std::vector<char>> was_asked(points.size(), std::vector<char>(boxes.size(), 0));
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const RankBox& box : boxes) nearest = std::min(nearest, box.distance2(points[v]));
    for (std::size_t r = 0; r < boxes.size(); ++r)
      if (boxes[r].tets > 0 && boxes[r].distance2(points[v]) <= nearest) {
        asked[r].push_back(v);
        was_asked[v][r] = 1;
      }
  }
  exchange->ask(asked, points, best);
  for (auto& list : asked) list.clear();
  for (std::uint32_t v = 0; v < points.size(); ++v)
    for (std::size_t r = 0; r < boxes.size(); ++r)
      if (!was_asked[v][r] && boxes[r].tets > 0 && boxes[r].distance2(points[v]) < best[v].distance2)
        asked[r].push_back(v);
  exchange->ask(asked, points, best);
  return fields_of(best, shapes, from.fields);
}

}  // namespace weft::tools
