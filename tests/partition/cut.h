// Cuts a whole mesh into starts of subdomains the simple way: everything at hand, nothing distributed.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "meshing/import_mesh.h"
#include "meshing/mesh_data.h"
#include "meshing/metric_field.h"
#include "partition/geometry.h"
#include "partition/refine_interface.h"
#include "partition/subdomain_start.h"

namespace weft::support {

struct Cut {
  partition::Geometry geometry;
  std::vector<partition::SubdomainStart> starts;
};

/// Tet t goes to subdomain part[t] of `count`.
inline Cut cut(const meshing::MeshData& mesh, const meshing::LogMetricField& log_metrics,
               const std::vector<partition::SubdomainId>& part, std::uint32_t count, double ridge_angle = 45) {
  using namespace meshing;
  using namespace partition;
  ImportedMesh imported = import_mesh(mesh, ridge_angle, mesh.points.size() + 1, mesh.tets.size() + 1);
  const TetMesh& whole = *imported.mesh;
  const std::size_t patches = imported.surface->patches().size();
  Cut result{{std::move(*imported.surface), imported.patch_required, std::vector<bool>(patches)}, {}};
  std::vector<bool> delicate(mesh.points.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& v = mesh.tets[t];
    if (is_delicate({mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]}))
      for (const std::uint32_t x : v) delicate[x] = true;
    for (int f = 0; f < 4; ++f)
      if (const PatchId p = whole.patch(TetId(t), f); p.valid() && whole.neighbour(TetId(t), f).valid())
        result.geometry.patch_inner[p.value] = true;
  }
  std::vector<std::set<SubdomainId>> holders(mesh.points.size());
  for (std::size_t t = 0; t < part.size(); ++t)
    for (const std::uint32_t v : mesh.tets[t]) holders[v].insert(part[t]);
  result.starts.resize(count);
  std::vector<std::map<std::uint32_t, std::uint32_t>> local(count);
  for (std::uint32_t t = 0; t < part.size(); ++t) {
    SubdomainStart& s = result.starts[part[t]];
    s.subdomain = part[t];
    std::array<std::uint32_t, 4> tet;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh.tets[t][i];
      const VertexId id(v);
      const auto [at, is_new] = local[part[t]].try_emplace(v, static_cast<std::uint32_t>(s.points.size()));
      tet[i] = at->second;
      if (!is_new) continue;
      s.points.push_back(mesh.points[v]);
      s.point_refs.push_back(mesh.point_refs[v]);
      s.log_metrics.push_back(log_metrics[v]);
      s.ids.emplace_back(*holders[v].begin(), v);
      s.kinds.push_back(whole.kind(id));
      s.flags.push_back(static_cast<std::uint8_t>(whole.flags(id) | (delicate[v] ? kDelicate : 0)));
      s.surface_hints.push_back(whole.surface_hint(id));
      for (const SubdomainId other : holders[v])
        if (other != part[t]) s.shared.push_back({at->second, other});
    }
    for (int f = 0; f < 4; ++f)
      if (whole.patch(TetId(t), f).valid())
        s.boundary_faces.push_back({static_cast<std::uint32_t>(s.tets.size()), static_cast<std::uint32_t>(f),
                                    whole.patch(TetId(t), f)});
    s.tets.push_back(tet);
    s.tet_refs.push_back(mesh.tet_refs[t]);
  }
  for (const auto& e : whole.feature_edges())
    for (std::uint32_t p = 0; p < count; ++p) {
      SubdomainStart& s = result.starts[p];
      s.subdomain = p;
      const auto a = local[p].find(e.a.value), b = local[p].find(e.b.value);
      if (a == local[p].end() || b == local[p].end()) continue;
      const bool has_edge = std::any_of(s.tets.begin(), s.tets.end(), [&](const auto& t) {
        return std::find(t.begin(), t.end(), a->second) != t.end() &&
               std::find(t.begin(), t.end(), b->second) != t.end();
      });
      if (has_edge) s.feature_edges.push_back({{a->second, b->second}, e.curve});
    }
  for (SubdomainStart& s : result.starts) std::sort(s.shared.begin(), s.shared.end());
  return result;
}

}  // namespace weft::support
