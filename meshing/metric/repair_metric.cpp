// Good values spread into the holes.
#include "meshing/metric/repair_metric.h"

#include <algorithm>
#include <cmath>

#include "meshing/base/error.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {
namespace {

SymTensor tensor_or_size_at(const Field& field, std::size_t i) {
  if (field.kind == Field::Kind::scalar) return identity_tensor(std::pow(field.values[i], -2));
  const double* v = &field.values[6 * i];
  return {v[0], v[1], v[2], v[3], v[4], v[5]};
}

bool is_good(const Field& field, std::size_t i) {
  if (field.kind == Field::Kind::scalar) return field.values[i] > 0 && std::isfinite(field.values[i]);
  const SymTensor m = tensor_or_size_at(field, i);
  return std::isfinite(m.xx + m.xy + m.yy + m.xz + m.yz + m.zz) && is_positive_definite(m);
}

void set(Field& field, std::size_t i, const LogMetric& log) {
  const Metric m = exp_exact(log);
  if (field.kind == Field::Kind::scalar) {
    field.values[i] = 1 / std::sqrt(m.xx);
    return;
  }
  const auto six = {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz};
  std::copy(six.begin(), six.end(), &field.values[6 * i]);
}

}  // namespace

std::vector<MeshMend> repair_metric(const MeshData& mesh, SolutionData& solution) {
  const auto is_metric = [](const Field& f) { return f.kind != Field::Kind::vector; };
  const auto found = std::find_if(solution.fields.begin(), solution.fields.end(), is_metric);
  if (found == solution.fields.end() || solution.num_points != mesh.points.size()) return {};
  Field& field = *found;
  std::vector<std::uint32_t> bad;
  std::vector<std::uint8_t> good(mesh.points.size(), 1);
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    if (!is_good(field, v)) bad.push_back(v), good[v] = 0;
  if (bad.empty()) return {};
  if (bad.size() == mesh.points.size())
    throw InputError("", "metric", "is not positive definite and finite at any vertex");
  MeshMend mend{"metrics that are not finite or not positive definite replaced by their neighbours' mean",
                "vertex",
                0,
                {},
                0,
                ""};
  for (const std::uint32_t v : bad) mend.add(v);
  const VertexLists near = vertex_neighbours(mesh.tets, mesh.points.size());
  while (!bad.empty()) {
    std::vector<std::uint32_t> left, mended;
    for (const std::uint32_t v : bad) {
      LogMetric sum{};
      double count = 0;
      for (const std::uint32_t n : near.of(v))
        if (good[n]) sum = sum + log_of(tensor_or_size_at(field, n)), ++count;
      if (count == 0) {
        left.push_back(v);
        continue;
      }
      set(field, v, (1 / count) * sum);
      mended.push_back(v);
    }
    if (mended.empty())
      throw InputError("", "metric of vertex " + std::to_string(left[0] + 1),
                       "is none, and no vertex with a good one is joined to it");
    for (const std::uint32_t v : mended) good[v] = 1;
    bad = std::move(left);
  }
  return {mend};
}

}  // namespace weft::meshing
