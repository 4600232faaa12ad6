// Transfer and its account.
#include "meshing/fields/transfer.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/fields/interpolate.h"
#include "meshing/fields/overlap_projection.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {
namespace {

double volume_of(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return std::max(0.0, six_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) / 6);
}

std::size_t width(const Field& field) { return static_cast<std::size_t>(components(field.kind)); }

SymTensor tensor_of(const Field& field, std::size_t v) {
  const double* t = field.values.data() + 6 * v;
  return {t[0], t[1], t[2], t[3], t[4], t[5]};
}

/// All components of all fields, those of one vertex together.
ValueTable packed(const SolutionData& fields) {
  ValueTable table;
  for (const Field& field : fields.fields) table.columns += width(field);
  table.values.resize(fields.num_points * table.columns);
  std::size_t first = 0;
  for (const Field& field : fields.fields) {
    const std::size_t n = width(field);
    for (std::size_t v = 0; v < fields.num_points; ++v)
      std::copy_n(field.values.data() + v * n, n, table.values.data() + v * table.columns + first);
    first += n;
  }
  return table;
}

void unpack(const ValueTable& table, SolutionData& fields) {
  std::size_t first = 0;
  for (Field& field : fields.fields) {
    const std::size_t n = width(field);
    for (std::size_t v = 0; v < fields.num_points; ++v)
      std::copy_n(table.values.data() + v * table.columns + first, n, field.values.data() + v * n);
    first += n;
  }
}

std::vector<ComponentAccount> named_accounts(const SolutionData& fields) {
  std::vector<ComponentAccount> accounts;
  for (std::size_t f = 0; f < fields.fields.size(); ++f) {
    const Field& field = fields.fields[f];
    const std::string name = field.name.empty() ? "field " + std::to_string(f + 1) : field.name;
    for (std::size_t c = 1; c <= width(field); ++c) {
      accounts.emplace_back();
      accounts.back().name = width(field) == 1 ? name : name + " " + std::to_string(c);
    }
  }
  return accounts;
}

/// The integral of the square of a function that is linear in a tet.
double square_integral(double volume, const std::array<double, 4>& u) {
  const double sum = u[0] + u[1] + u[2] + u[3];
  return volume / 20 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3] + sum * sum);
}

void account_differences(const MeshData& from, const ValueTable& old, const ValueTable& back,
                         std::vector<ComponentAccount>& accounts) {
  const std::size_t n = old.columns;
  for (std::size_t t = 0; t < from.tets.size(); ++t) {
    const double volume = volume_of(from, t);
    for (std::size_t c = 0; c < n; ++c) {
      std::array<double, 4> value, difference;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t at = from.tets[t][i] * n + c;
        value[i] = old.values[at];
        difference[i] = back.values[at] - value[i];
        accounts[c].absolute += volume / 4 * std::abs(value[i]);
      }
      accounts[c].norm_l2 += square_integral(volume, value);
      accounts[c].difference_l2 += square_integral(volume, difference);
    }
  }
  for (std::size_t i = 0; i < old.values.size(); ++i) {
    ComponentAccount& account = accounts[i % n];
    account.norm_max = std::max(account.norm_max, std::abs(old.values[i]));
    account.difference_max = std::max(account.difference_max, std::abs(back.values[i] - old.values[i]));
  }
  for (ComponentAccount& account : accounts) {
    account.norm_l2 = std::sqrt(account.norm_l2);
    account.difference_l2 = std::sqrt(account.difference_l2);
  }
}

bool is_definite(const Field& field) {
  if (field.kind != Field::Kind::tensor) return false;
  const std::size_t count = field.values.size() / 6;
  return find_first(count, [&](std::size_t v) { return !is_positive_definite(tensor_of(field, v)); }) ==
         count;
}

/// Appends the least and the largest eigenvalue of each definite tensor field, as fields whose bounds are
/// those of the eigenvalues: linear interpolation of tensors keeps between such of their eigenvalues.
std::vector<TensorColumns> append_eigenvalues(SolutionData& fields) {
  std::vector<TensorColumns> tensors;
  std::size_t first = 0, end = 0;
  for (const Field& field : fields.fields) end += width(field);
  const std::size_t count = fields.fields.size();
  for (std::size_t f = 0; f < count; first += width(fields.fields[f++])) {
    if (!is_definite(fields.fields[f])) continue;
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

/// Replaces the fields interpolated from `old` by their projection; accounts for its bounds.
void conserve(const Background& from, const SolutionData& old, const std::vector<TensorColumns>& tensors,
              const MeshData& to, Interpolation& linear, std::vector<ComponentAccount>& accounts) {
  const ValueTable old_table = packed(old);
  ValueTable table = packed(linear.fields);
  const std::vector<double> beyond =
      project(from, old_table, to, linear.places, integrals(from.mesh(), old_table), tensors, table);
  unpack(table, linear.fields);
  for (std::size_t c = 0; c < accounts.size(); ++c) accounts[c].beyond_bounds = beyond[c];
  for (const TensorColumns& t : tensors)
    for (std::size_t c = 0; c < 6; ++c) accounts[t.first + c].stays_definite = true;
}

}  // namespace

Transfer transfer(const MeshData& from, const SolutionData& fields, const MeshData& to,
                  TransferMethod method) {
  Transfer result;
  result.accounts = named_accounts(fields);
  const ValueTable old = packed(fields);
  const std::vector<double> before = integrals(from, old);
  {
    const Background background = field_background(from);
    SolutionData extended = fields;
    const bool conservative = method == TransferMethod::conservative;
    const auto tensors = conservative ? append_eigenvalues(extended) : std::vector<TensorColumns>();
    Interpolation linear = interpolate(background, extended, to);
    if (conservative) conserve(background, extended, tensors, to, linear, result.accounts);
    result.fields = std::move(linear.fields);
    result.fields.fields.resize(fields.fields.size());
    result.outside = linear.outside;
    result.farthest = linear.farthest;
  }
  const std::vector<double> after = integrals(to, packed(result.fields));
  for (std::size_t c = 0; c < before.size(); ++c) {
    result.accounts[c].integral_before = before[c];
    result.accounts[c].integral_after = after[c];
  }
  account_differences(from, old, packed(interpolate(to, result.fields, from).fields), result.accounts);
  return result;
}

}  // namespace weft::meshing
