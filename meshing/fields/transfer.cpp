// Transfer and its account.
#include "meshing/fields/transfer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/freed_memory.h"
#include "meshing/base/parallel.h"
#include "meshing/base/release.h"
#include "meshing/fields/interpolate.h"
#include "meshing/fields/overlap_projection.h"
#include "meshing/fields/reading.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {
namespace {

double volume_of(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return std::max(0.0, six_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) / 6);
}

std::size_t columns_of(const Field& field) { return static_cast<std::size_t>(components(field.kind)); }

SymTensor tensor_of(const Field& field, std::size_t v) {
  const double* t = field.values.data() + 6 * v;
  return {t[0], t[1], t[2], t[3], t[4], t[5]};
}

std::vector<ComponentAccount> named_accounts(const SolutionData& fields) {
  std::vector<ComponentAccount> accounts;
  for (std::size_t f = 0; f < fields.fields.size(); ++f) {
    const Field& field = fields.fields[f];
    const std::string name = field.name.empty() ? "field " + std::to_string(f + 1) : field.name;
    for (std::size_t c = 1; c <= columns_of(field); ++c) {
      accounts.emplace_back();
      accounts.back().name = columns_of(field) == 1 ? name : name + " " + std::to_string(c);
    }
  }
  return accounts;
}

/// The integral of the square of a function that is linear in a tet.
double square_integral(double volume, const std::array<double, 4>& u) {
  const double sum = u[0] + u[1] + u[2] + u[3];
  return volume / 20 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3] + sum * sum);
}

/// What the tets give to the integrals of one component, each at its first vertex.
struct Shares {
  std::vector<double> absolute, norm_l2, difference_l2;
};

Shares shares_of(const MeshData& mesh, const ValueTable& old, const ValueTable& back, std::size_t column) {
  const std::size_t points = mesh.points.size();
  Shares shares{std::vector<double>(points), std::vector<double>(points), std::vector<double>(points)};
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = volume_of(mesh, t);
    const std::size_t first = std::ranges::min(mesh.tets[t]);
    std::array<double, 4> value, difference;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t at = mesh.tets[t][i] * old.columns + column;
      value[i] = old.values[at];
      difference[i] = back.values[at] - value[i];
      shares.absolute[first] += volume / 4 * std::abs(value[i]);
    }
    shares.norm_l2[first] += square_integral(volume, value);
    shares.difference_l2[first] += square_integral(volume, difference);
  }
  return shares;
}

void account_differences(const MetricDomain& from, const ValueTable& old, const ValueTable& back,
                         std::vector<ComponentAccount>& accounts) {
  for (std::size_t c = 0; c < accounts.size(); ++c) {
    ComponentAccount& account = accounts[c];
    const Shares shares = shares_of(from.mesh(), old, back, c);
    const auto sum = [&](const std::vector<double>& at) {
      return from.sum([&](std::size_t v) { return at[v]; });
    };
    account.absolute = sum(shares.absolute);
    account.norm_l2 = std::sqrt(sum(shares.norm_l2));
    account.difference_l2 = std::sqrt(sum(shares.difference_l2));
    double norm = 0, difference = 0;
    for (std::size_t at = c; at < old.values.size(); at += old.columns) {
      norm = std::max(norm, std::abs(old.values[at]));
      difference = std::max(difference, std::abs(back.values[at] - old.values[at]));
    }
    account.norm_max = from.max(norm);
    account.difference_max = from.max(difference);
  }
}

bool is_definite(const MetricDomain& domain, const Field& field) {
  if (field.kind != Field::Kind::tensor) return false;
  const std::size_t count = field.values.size() / 6;
  const std::size_t bad =
      find_first(count, [&](std::size_t v) { return !is_positive_definite(tensor_of(field, v)); });
  return !domain.any(bad < count);
}

/// Appends the least and the largest eigenvalue of each definite tensor field, as fields whose bounds are
/// those of the eigenvalues: linear interpolation of tensors keeps between such of their eigenvalues.
std::vector<TensorColumns> append_eigenvalues(const MetricDomain& domain, SolutionData& fields) {
  std::vector<TensorColumns> tensors;
  std::size_t first = 0, end = 0;
  for (const Field& field : fields.fields) end += columns_of(field);
  const std::size_t count = fields.fields.size();
  for (std::size_t f = 0; f < count; first += columns_of(fields.fields[f++])) {
    if (!is_definite(domain, fields.fields[f])) continue;
    std::vector<double> least(fields.num_points), largest(fields.num_points);
    for_each_index(fields.num_points, [&](std::size_t v) {
      const Eigen3 e = eigen_decomposition(tensor_of(fields.fields[f], v));
      least[v] = e.values[0];
      largest[v] = e.values[2];
    });
    fields.fields.push_back({Field::Kind::scalar, std::move(least), {}});
    fields.fields.push_back({Field::Kind::scalar, std::move(largest), {}});
    tensors.push_back({first, end, end + 1});
    end += 2;
  }
  return tensors;
}

/// Replaces what was read by its projection and accounts for its bounds; false: was interrupted before.
bool conserve(MeshPair& meshes, std::span<const double> wanted, const std::vector<TensorColumns>& tensors,
              Reading& reading, std::vector<ComponentAccount>& accounts) {
  const auto old_is_read = [&] {
    reading.locator.reset();
    release(reading.source.values);
    release(reading.at.places);
    meshes.release_source();
  };
  const auto beyond = project(reading.locator.get(), reading.source, meshes.new_mesh(), reading.at.places,
                              wanted, tensors, reading.at.table, old_is_read);
  if (!beyond) return false;
  for (std::size_t c = 0; c < accounts.size(); ++c) accounts[c].beyond_bounds = (*beyond)[c];
  for (const TensorColumns& t : tensors)
    for (std::size_t c = 0; c < 6; ++c) accounts[t.first + c].stays_definite = true;
  return true;
}

void account_for_outside(const MetricDomain& to, const ValuesAt& at, Transfer& result) {
  double farthest = 0;
  for (std::size_t v = 0; v < at.distances.size(); ++v)
    if (at.outside[v]) farthest = std::max(farthest, at.distances[v]);
  result.farthest = to.max(farthest);
  result.outside = static_cast<std::uint64_t>(
      std::llround(to.sum([&](std::size_t v) { return at.outside[v] ? 1.0 : 0.0; })));
}

void check_tets(const MeshPair& meshes) {
  const auto has_tets = [](const MetricDomain& domain) { return domain.any(!domain.mesh().tets.empty()); };
  if (!has_tets(meshes.old_mesh())) throw InputError("", "", "has no tetrahedra");
  of_new_mesh([&] {
    if (!has_tets(meshes.new_mesh())) throw InputError("", "", "has no tetrahedra");
    check_volumes(meshes.new_mesh().mesh());
  });
}

}  // namespace

Transfer transfer(const MeshData& from, const SolutionData& fields, const MeshData& to, TransferMethod method,
                  const std::atomic<bool>* interrupt) {
  WholePair meshes(from, to, interrupt);
  return transfer(meshes, fields, method);
}

Transfer transfer(MeshPair& meshes, const SolutionData& fields, TransferMethod method) {
  check_tets(meshes);
  Transfer result;
  result.accounts = named_accounts(fields);
  SolutionData extended = fields;
  const bool conservative = method == TransferMethod::conservative;
  const auto tensors =
      conservative ? append_eigenvalues(meshes.old_mesh(), extended) : std::vector<TensorColumns>();
  const ValueTable old = packed(extended);
  extended = {};
  const std::vector<double> before = integrals(meshes.old_mesh(), old);
  Reading reading = read(meshes, old);
  account_for_outside(meshes.new_mesh(), reading.at, result);
  if (conservative && conserve(meshes, before, tensors, reading, result.accounts)) result.method = method;
  const ValueTable carried = std::move(reading.at.table);
  reading = {};
  meshes.release_source();
  give_back_freed_memory();  // the way back may need the most of all
  const std::vector<double> after = integrals(meshes.new_mesh(), carried);
  for (std::size_t c = 0; c < result.accounts.size(); ++c) {
    result.accounts[c].integral_before = before[c];
    result.accounts[c].integral_after = after[c];
  }
  const ValueTable back = of_new_mesh([&] { return meshes.read_back(carried); });
  account_differences(meshes.old_mesh(), old, back, result.accounts);
  for (const Field& field : fields.fields) result.fields.fields.push_back({field.kind, {}, field.name});
  unpack(carried, result.fields);
  return result;
}

Transfer keep_fields(const MetricDomain& mesh, const SolutionData& fields, TransferMethod method) {
  Transfer result{fields, 0, 0, named_accounts(fields), method};
  const ValueTable values = packed(fields);
  const std::vector<double> sums = integrals(mesh, values);
  for (std::size_t c = 0; c < result.accounts.size(); ++c)
    result.accounts[c].integral_before = result.accounts[c].integral_after = sums[c];
  account_differences(mesh, values, values, result.accounts);
  if (method != TransferMethod::conservative) return result;
  auto account = result.accounts.begin();
  for (const Field& field : fields.fields) {
    const bool definite = is_definite(mesh, field);
    for (std::size_t c = 0; c < columns_of(field); ++c) (account++)->stays_definite = definite;
  }
  return result;
}

}  // namespace weft::meshing
