// Cuts a whole mesh into starts of subdomains the simple way: everything at hand, nothing distributed.
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "meshing/kernel/import_mesh.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/refine/refine_interface.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/subdomain_start.h"
#include "partition/subdomain/surface_cover.h"

namespace weft::support {

struct Cut {
  partition::Geometry geometry;
  std::vector<partition::SubdomainStart> starts;  ///< by subdomain; some may be empty
};

class Cutting {
 public:
  /// Tet t goes to subdomain part[t]. All points must belong to tets.
  Cutting(const meshing::MeshData& mesh, const meshing::LogMetricField& log_metrics,
          const std::vector<partition::SubdomainId>& part, double ridge_angle)
      : mesh_(mesh),
        log_metrics_(log_metrics),
        part_(part),
        imported_(import_mesh(mesh, ridge_angle, mesh.points.size() + 1, mesh.tets.size() + 1)),
        holders_(mesh.points.size()),
        delicate_(mesh.points.size()) {
    for (std::size_t t = 0; t < part.size(); ++t)
      for (const std::uint32_t v : mesh.tets[t]) holders_[v].insert(part[t]);
  }

  Cut cut(std::uint32_t subdomains) {
    const std::size_t patches = imported_.surface->patches().size();
    std::vector<bool> inner(patches);
    for (std::uint32_t t = 0; t < part_.size(); ++t) find_inner_patches(t, inner);
    mark_delicate();
    starts_.resize(subdomains);
    local_.resize(subdomains);
    for (std::uint32_t s = 0; s < subdomains; ++s) starts_[s].subdomain = partition::SubdomainId(s);
    for (std::uint32_t t = 0; t < part_.size(); ++t) add_tet(t);
    for (const auto& e : imported_.mesh->feature_edges()) add_feature_edge(e);
    for (auto& s : starts_) std::sort(s.shared.begin(), s.shared.end());
    for (auto& s : starts_) s.surface = cover_of(s).pieces(imported_.surface->pieces());
    return {{std::move(*imported_.surface), imported_.patch_required, std::move(inner)}, std::move(starts_)};
  }

 private:
  using VertexId = meshing::VertexId;
  using TetId = meshing::TetId;

  void find_inner_patches(std::uint32_t t, std::vector<bool>& inner) const {
    const meshing::TetMesh& whole = *imported_.mesh;
    for (int f = 0; f < 4; ++f)
      if (const auto p = whole.patch(TetId(t), f); p.valid() && whole.neighbour(TetId(t), f).valid())
        inner[p.value] = true;
  }

  void mark_delicate() {
    const auto& x = mesh_.points;
    for (const auto& v : mesh_.tets)
      if (partition::is_delicate({x[v[0]], x[v[1]], x[v[2]], x[v[3]]}))
        for (const std::uint32_t corner : v) delicate_[corner] = true;
  }

  void add_tet(std::uint32_t t) {
    partition::SubdomainStart& s = starts_[part_[t].value];
    const auto number = static_cast<std::uint32_t>(s.tets.size());
    std::array<std::uint32_t, 4> tet;
    for (int i = 0; i < 4; ++i) tet[i] = add_vertex(s, mesh_.tets[t][i]);
    for (std::uint32_t f = 0; f < 4; ++f)
      if (const auto p = imported_.mesh->patch(TetId(t), static_cast<int>(f)); p.valid())
        s.boundary_faces.push_back({number, f, p});
    s.tets.push_back(tet);
    s.tet_refs.push_back(mesh_.tet_refs[t]);
  }

  /// Its number in the subdomain.
  std::uint32_t add_vertex(partition::SubdomainStart& s, std::uint32_t v) {
    const auto [at, is_new] =
        local_[s.subdomain.value].try_emplace(v, static_cast<std::uint32_t>(s.points.size()));
    if (!is_new) return at->second;
    const meshing::TetMesh& whole = *imported_.mesh;
    s.points.push_back(mesh_.points[v]);
    s.point_refs.push_back(mesh_.point_refs[v]);
    s.log_metrics.push_back(log_metrics_[v]);
    s.ids.emplace_back(*holders_[v].begin(), v);
    s.kinds.push_back(whole.kind(VertexId(v)));
    s.flags.push_back(
        static_cast<std::uint8_t>(whole.flags(VertexId(v)) | (delicate_[v] ? partition::kDelicate : 0)));
    s.surface_hints.push_back(whole.surface_hint(VertexId(v)));
    for (const partition::SubdomainId other : holders_[v])
      if (other != s.subdomain) s.shared.push_back({at->second, other});
    return at->second;
  }

  /// To each subdomain that has a tet with the edge.
  void add_feature_edge(const meshing::TetMesh::FeatureEdge& e) {
    for (partition::SubdomainStart& s : starts_) {
      const auto& local = local_[s.subdomain.value];
      const auto a = local.find(e.a.value), b = local.find(e.b.value);
      if (a == local.end() || b == local.end()) continue;
      const bool has_edge = std::any_of(s.tets.begin(), s.tets.end(), [&](const auto& t) {
        return std::find(t.begin(), t.end(), a->second) != t.end() &&
               std::find(t.begin(), t.end(), b->second) != t.end();
      });
      if (has_edge) s.feature_edges.push_back({{a->second, b->second}, e.curve});
    }
  }

  const meshing::MeshData& mesh_;
  const meshing::LogMetricField& log_metrics_;
  const std::vector<partition::SubdomainId>& part_;
  meshing::ImportedMesh imported_;
  std::vector<std::set<partition::SubdomainId>> holders_;
  std::vector<bool> delicate_;
  std::vector<partition::SubdomainStart> starts_;
  std::vector<std::map<std::uint32_t, std::uint32_t>>
      local_;  ///< of each subdomain: number in the input -> its own
};

}  // namespace weft::support
