// Parsing, without leniency: a word left over is an error.
#include "tools/library/pictures/picture_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace weft::tools {
namespace {

using picture::Canvas;

template <class Number>
Number number_in(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(static_cast<double>(value)))
    throw std::invalid_argument(fmt::format("'{}' is not a number", text));
  return value;
}

}  // namespace

Canvas::Format picture_format(const std::string& name) {
  return Canvas::format_of(name).value_or(Canvas::Format::png);
}

std::vector<double> numbers_in(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  std::string_view rest = text;
  for (std::size_t comma = 0; comma != std::string_view::npos;) {
    comma = rest.find(',');
    numbers.push_back(number_in<double>(rest.substr(0, comma)));
    if (comma != std::string_view::npos) rest.remove_prefix(comma + 1);
  }
  if (numbers.size() != count)
    throw std::invalid_argument(fmt::format("'{}' has {} numbers, not {}", text, numbers.size(), count));
  return numbers;
}

std::pair<int, int> picture_size(const std::string& text) {
  constexpr int kLeast = 16, kMost = 16000;
  const auto by = text.find('x');
  if (by == std::string::npos) throw std::invalid_argument("'" + text + "' is not WIDTHxHEIGHT");
  const int width = number_in<int>(std::string_view(text).substr(0, by));
  const int height = number_in<int>(std::string_view(text).substr(by + 1));
  if (std::min(width, height) < kLeast || std::max(width, height) > kMost)
    throw std::invalid_argument(fmt::format("'{}' is not within {} and {} pixels", text, kLeast, kMost));
  return {width, height};
}

meshing::Box box_in(const std::string& text) {
  const std::vector<double> x = numbers_in(text, 6);
  meshing::Box box;
  box.include({x[0], x[1], x[2]});
  box.include({x[3], x[4], x[5]});
  return box;
}

picture::Plane plane_in(const std::string& text, const meshing::Vec& toward_eye) {
  if (text.size() > 2 && text[0] >= 'x' && text[0] <= 'z' && text[1] == '=') {
    const int axis = text[0] - 'x';
    const double sign = toward_eye[axis] < 0 ? -1 : 1;
    picture::Plane plane{{}, sign * number_in<double>(std::string_view(text).substr(2))};
    plane.normal[axis] = sign;
    return plane;
  }
  if (text.find(',') == std::string::npos)
    throw std::invalid_argument("'" + text + "' is neither like x=0.5 nor PX,PY,PZ,NX,NY,NZ");
  const std::vector<double> x = numbers_in(text, 6);
  const meshing::Vec normal = {x[3], x[4], x[5]};
  if (!(norm(normal) > 0)) throw std::invalid_argument("'" + text + "' has a normal of length zero");
  const meshing::Vec unit = (1 / norm(normal)) * normal;
  return {unit, dot(unit, {x[0], x[1], x[2]})};
}

}  // namespace weft::tools
