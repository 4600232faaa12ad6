// Power laws fitted to measured times, robustly, by Ceres' TinySolver.
#include "engine/schedule/cost_model.h"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace weft::engine {
namespace {

constexpr std::size_t kWindow = 256;    // samples that a fit looks at
constexpr std::uint64_t kFirstFit = 8;  // samples before it
constexpr double kUnknown = 1e-4;       // seconds, when nothing was said or measured
constexpr double kLeast = 1e-9;         // seconds: what a clock can tell from nothing
constexpr double kMost = 1e9;           // seconds: 30 years
constexpr double kMaxSlope = 3;
constexpr double kLeastSpread = 0.2;    // of log(expected), 1st to 9th decile: less tells no slope
constexpr double kObjectMemory = 0.25;  // weight of the latest run of an object
constexpr double kMethodMemory = 1.0 / kWindow;
const double kMaxBias = std::log(8.0);  // of an object

/// The log of a time, kept in a range in which nothing overflows.
double log_of(double seconds) { return std::log(std::clamp(seconds, kLeast, kMost)); }

/// `mean` after the `count`th value: the plain mean at first, fading memory later.
double updated(double mean, double value, std::uint64_t count, double memory) {
  return mean + std::max(memory, 1.0 / static_cast<double>(count)) * (value - mean);
}

/// The value below which `share` of them lie. Reorders them; there must be one.
double quantile(std::vector<double>& values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

/// Weighted residuals of a line through points (x, y), plus one that pulls the slope to 1.
class LineResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 2 };

  LineResiduals(std::vector<double> x, std::vector<double> y)
      : x_(std::move(x)), y_(std::move(y)), weight_(x_.size(), 1.0) {}

  int NumResiduals() const { return static_cast<int>(x_.size()) + 1; }
  bool operator()(const double* line, double* residuals, double* jacobian) const {
    const std::size_t n = x_.size();
    for (std::size_t i = 0; i < n; ++i) residuals[i] = weight_[i] * misfit(line, i);
    residuals[n] = prior_ * (1 - line[1]);
    if (jacobian == nullptr) return true;
    for (std::size_t i = 0; i < n; ++i) {
      jacobian[i] = -weight_[i];
      jacobian[n + 1 + i] = -weight_[i] * x_[i];
    }
    jacobian[n] = 0;
    jacobian[n + 1 + n] = -prior_;
    return true;
  }

  std::size_t size() const { return x_.size(); }
  double x(std::size_t i) const { return x_[i]; }
  double misfit(const double* line, std::size_t i) const { return y_[i] - line[0] - line[1] * x_[i]; }

  /// Gives less weight to samples that lie off `line`, by Cauchy's loss, and the slope's prior as much as one
  /// sample with the scatter of the others: it decides only where they do not.
  void reweight(const double* line) {
    std::vector<double> off(x_.size());
    for (std::size_t i = 0; i < off.size(); ++i) off[i] = std::abs(misfit(line, i));
    constexpr double kDeviationsInMedian = 1.4826;  // of a normal distribution
    constexpr double kTuning = 2.385;               // Cauchy's loss then loses 5 % if there are no outliers
    prior_ = std::max(1e-6, kDeviationsInMedian * quantile(off, 0.5));
    for (std::size_t i = 0; i < off.size(); ++i) {
      const double ratio = misfit(line, i) / (kTuning * prior_);
      weight_[i] = 1 / std::sqrt(1 + ratio * ratio);
    }
  }

 private:
  std::vector<double> x_, y_;
  std::vector<double> weight_;  // square roots of the weights
  double prior_ = 0;
};

/// Iteratively reweighted least squares; nothing if it came to no number.
std::optional<CostModel::Curve> fit_line(LineResiduals& residuals) {
  constexpr int kRounds = 10;
  constexpr double kSettled =
      1e-3;  // a thousandth of a factor or of the slope: nothing beside the samples' scatter
  ceres::TinySolver<LineResiduals> solver;
  solver.options.max_num_iterations = 5;  // the problem is linear: one does it but for the damping
  Eigen::Vector2d line(0, 1);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector2d before = line;
    solver.Solve(residuals, &line);
    if (!line.allFinite()) return std::nullopt;
    residuals.reweight(line.data());
    if (round > 0 && (line - before).norm() < kSettled) break;  // the first round has no weights yet
  }
  return CostModel::Curve{line[0], line[1]};
}

/// The median distance of the points from a line with this slope through 0.
double intercept_for(double slope, const LineResiduals& residuals) {
  const double line[2] = {0, slope};
  std::vector<double> distances(residuals.size());
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = residuals.misfit(line, i);
  return quantile(distances, 0.5);
}

/// A curve through the points; slope 1 where the x hardly differ.
CostModel::Curve fit(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> sorted = x;
  const double middle = quantile(sorted, 0.5);
  const double spread = quantile(sorted, 0.9) - quantile(sorted, 0.1);
  std::vector<double> centred(x.size());  // else the two unknowns can hardly be told apart
  std::transform(x.begin(), x.end(), centred.begin(), [&](double value) { return value - middle; });
  LineResiduals residuals(std::move(centred), y);
  auto curve = spread < kLeastSpread ? std::nullopt : fit_line(residuals);
  const double slope = curve ? std::clamp(curve->slope, 0.0, kMaxSlope) : 1;
  if (!curve || slope != curve->slope) curve = CostModel::Curve{intercept_for(slope, residuals), slope};
  return {curve->intercept - slope * middle, slope};
}

bool is_time_to_fit(std::uint64_t samples) {
  if (samples < kFirstFit) return false;
  return samples <= kWindow ? std::has_single_bit(samples) : samples % kWindow == 0;
}

double on(const CostModel::Curve& curve, double log_expected) {
  return curve.intercept + curve.slope * log_expected;
}

Experience& experience_of(std::uint32_t method, Experiences& object) {
  for (Experience& own : object)
    if (own.method == method) return own;
  return object.emplace_back(Experience{.method = method});
}

}  // namespace

CostModel::CostModel(std::size_t methods) : methods_(methods) {}

double CostModel::predict(std::uint32_t method, const Experiences& object, double expected) const {
  const Method& all = methods_.at(method);
  const auto own =
      std::find_if(object.begin(), object.end(), [&](const Experience& e) { return e.method == method; });
  const bool known = own != object.end();
  if (!(expected > 0)) {  // NaN too
    if (known) return own->mean_seconds;
    return all.measured > 0 ? all.mean_seconds : kUnknown;
  }
  const double log_seconds = on(all.curve, log_of(expected)) + (known ? own->log_bias : 0);
  return std::clamp(std::exp(log_seconds), kLeast, kMost);
}

void CostModel::measured(std::uint32_t method, Experiences& object, double expected, double seconds) {
  Method& all = methods_.at(method);
  if (!(seconds >= 0) || !std::isfinite(seconds)) return;
  seconds = std::clamp(seconds, kLeast, kMost);
  Experience& own = experience_of(method, object);
  all.mean_seconds = updated(all.mean_seconds, seconds, ++all.measured, kMethodMemory);
  own.mean_seconds = updated(own.mean_seconds, seconds, ++own.measured, kObjectMemory);
  if (!(expected > 0)) return;
  const Sample sample{log_of(expected), std::log(seconds)};
  add_sample(all, sample);
  if (!all.fitted) return;  // what the whole method is off is not this object's doing
  const double bias =
      std::clamp(sample.log_seconds - on(all.curve, sample.log_expected), -kMaxBias, kMaxBias);
  own.log_bias += kObjectMemory * (bias - own.log_bias);
}

void CostModel::add_sample(Method& method, Sample sample) {
  if (method.latest.size() < kWindow) {
    method.latest.push_back(sample);
  } else {
    method.latest[method.samples % kWindow] = sample;
  }
  if (!is_time_to_fit(++method.samples)) return;
  std::vector<double> x, y;
  for (const Sample& s : method.latest) x.push_back(s.log_expected), y.push_back(s.log_seconds);
  method.curve = fit(x, y);
  method.fitted = true;
}

}  // namespace weft::engine
