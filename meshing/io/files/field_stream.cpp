#include "meshing/io/files/field_stream.h"

#include <algorithm>
#include <utility>

namespace weft::meshing {

StreamedField::StreamedField(std::string name, std::uint64_t length, std::uint64_t first_point,
                             std::uint64_t num_points)
    : name_(std::move(name)),
      length_(length),
      first_(first_point),
      values_(length * num_points),
      given_(num_points) {}

void StreamedField::add(std::span<const std::uint32_t> points, std::span<const double> values) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = points[i] - first_;
    std::ranges::copy(values.subspan(i * length_, length_),
                      values_.begin() + static_cast<std::ptrdiff_t>(at * length_));
    num_given_ += !given_[at];
    given_[at] = true;
  }
}

std::optional<Field> StreamedField::take() {
  if (length_ < 9)
    return Field{length_ == 1 ? Field::Kind::scalar : Field::Kind::vector, std::move(values_), name_};
  std::vector<double> folded;
  if (!fold_full_tensors(values_, folded)) return std::nullopt;
  return Field{Field::Kind::tensor, std::move(folded), name_};
}

void FieldCollector::begin(const std::string& name, std::uint64_t length, std::uint64_t points) {
  num_points_ = points;
  field_.emplace(name, length, 0, points);
}

void FieldCollector::take(std::vector<std::uint32_t> points, std::vector<double> values) {
  field_->add(points, values);
}

void FieldCollector::end() {
  if (field_->num_given() < num_points_) return contents_.drop(kFieldsWithGaps);
  std::optional<Field> field = field_->take();
  if (!field) return contents_.drop(kSkewTensors);
  contents_.fields.fields.push_back(std::move(*field));
}

}  // namespace weft::meshing
