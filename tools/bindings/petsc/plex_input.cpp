#include "tools/bindings/petsc/plex_input.h"

#include <petscsf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "tools/bindings/petsc/agreement.h"

namespace weft::petsc {
namespace {

/// The points of a DMPlex by kind.
struct Strata {
  PetscInt cells = 0, cells_end = 0, faces = 0, faces_end = 0, vertices = 0, vertices_end = 0, end = 0;
};

PetscErrorCode strata_of(DM dm, Strata& strata) {
  PetscInt start = 0;
  PetscFunctionBegin;
  PetscCall(DMPlexGetChart(dm, &start, &strata.end));
  PetscCall(DMPlexGetHeightStratum(dm, 0, &strata.cells, &strata.cells_end));
  PetscCall(DMPlexGetHeightStratum(dm, 1, &strata.faces, &strata.faces_end));
  PetscCall(DMPlexGetDepthStratum(dm, 0, &strata.vertices, &strata.vertices_end));
  PetscFunctionReturn(0);
}

/// All ranks.
PetscErrorCode check_plex(DM dm, const Strata& strata) {
  PetscBool plex = PETSC_FALSE, localized = PETSC_FALSE;
  PetscInt dim = 0, coordinate_dim = 0;
  DMPlexInterpolatedFlag interpolated = DMPLEX_INTERPOLATED_INVALID;
  PetscFunctionBegin;
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(dm), DMPLEX, &plex));
  PetscCheck(plex, comm, PETSC_ERR_SUP, "weft adapts meshes of type DMPLEX only");
  PetscCall(DMGetDimension(dm, &dim));
  PetscCall(DMGetCoordinateDim(dm, &coordinate_dim));
  PetscCheck(dim == 3 && coordinate_dim == 3, comm, PETSC_ERR_SUP,
             "weft adapts tetrahedral meshes in space; this one has dimension %" PetscInt_FMT
             " in %" PetscInt_FMT,
             dim, coordinate_dim);
  PetscCall(DMGetCoordinatesLocalized(dm, &localized));
  PetscCheck(!localized, comm, PETSC_ERR_SUP, "weft does not adapt periodic meshes");
  PetscCall(DMPlexIsInterpolatedCollective(dm, &interpolated));
  PetscCheck(interpolated == DMPLEX_INTERPOLATED_FULL, comm, PETSC_ERR_SUP,
             "weft needs the faces and edges of the mesh: call DMPlexInterpolate() (-dm_plex_interpolate)");
  std::string issue;
  for (PetscInt c = strata.cells; issue.empty() && c < strata.cells_end; ++c) {
    DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
    PetscCall(DMPlexGetCellType(dm, c, &type));
    if (type != DM_POLYTOPE_TETRAHEDRON)
      issue = "cell " + std::to_string(c) + " is a " + DMPolytopeTypes[type] + ": all must be tetrahedra";
  }
  PetscCall(agree(comm, PETSC_ERR_SUP, issue));
  PetscFunctionReturn(0);
}

/// Which points other ranks own: those of the overlap and those that parts share.
PetscErrorCode foreign_points(DM dm, const Strata& strata, std::vector<char>& foreign) {
  PetscSF sf = nullptr;
  PetscInt roots = -1, leaves = 0;
  const PetscInt* points = nullptr;
  PetscFunctionBegin;
  foreign.assign(static_cast<std::size_t>(strata.end), 0);
  PetscCall(DMGetPointSF(dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &roots, &leaves, &points, nullptr));
  for (PetscInt i = 0; roots >= 0 && i < leaves; ++i)
    foreign[static_cast<std::size_t>(points ? points[i] : i)] = 1;
  PetscFunctionReturn(0);
}

/// Fills a part. Every member function is one step, in the order of read().
class Reader {
 public:
  Reader(DM dm, PlexInput& input) : dm_(dm), input_(input), part_(input.part), metric_(input.metric) {}

  PetscErrorCode read(Vec metric, DMLabel bd_label, DMLabel rg_label) {
    PetscFunctionBegin;
    PetscCall(strata_of(dm_, strata_));
    PetscCall(check_plex(dm_, strata_));
    PetscCall(foreign_points(dm_, strata_, foreign_));
    PetscCall(add_tets(rg_label));
    PetscCall(add_points());
    orient_tets();
    PetscCall(add_faces(bd_label));
    PetscCall(add_metric(metric));
    PetscFunctionReturn(0);
  }

 private:
  MPI_Comm comm() const { return PetscObjectComm(reinterpret_cast<PetscObject>(dm_)); }
  bool own_cell(PetscInt c) const { return !foreign_[static_cast<std::size_t>(c)]; }

  /// The vertices of a cell or face.
  template <std::size_t N>
  PetscErrorCode vertices_of(PetscInt point, std::array<PetscInt, N>& vertices) const {
    PetscInt size = 0, *closure = nullptr;
    std::size_t found = 0;
    PetscFunctionBegin;
    PetscCall(DMPlexGetTransitiveClosure(dm_, point, PETSC_TRUE, &size, &closure));
    for (PetscInt i = 0; i < size; ++i)
      if (closure[2 * i] >= strata_.vertices && closure[2 * i] < strata_.vertices_end && found < N)
        vertices[found++] = closure[2 * i];
    PetscCall(DMPlexRestoreTransitiveClosure(dm_, point, PETSC_TRUE, &size, &closure));
    PetscFunctionReturn(0);
  }

  std::uint32_t& local(PetscInt vertex) {
    return local_[static_cast<std::size_t>(vertex - strata_.vertices)];
  }

  static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

  /// Numbers the vertices as they come.
  PetscErrorCode add_tets(DMLabel rg_label) {
    std::vector<std::int32_t> regions;
    PetscInt unset = 0;
    PetscFunctionBegin;
    if (rg_label) PetscCall(DMLabelGetDefaultValue(rg_label, &unset));
    PetscCall(references_of(dm_, rg_label, strata_.cells, strata_.cells_end, unset, regions, input_.regions));
    local_.assign(static_cast<std::size_t>(strata_.vertices_end - strata_.vertices), kUnused);
    for (PetscInt c = strata_.cells; c < strata_.cells_end; ++c) {
      if (!own_cell(c)) continue;
      std::array<PetscInt, 4> vertices{};
      PetscCall(vertices_of(c, vertices));
      std::array<std::uint32_t, 4> tet{};
      for (std::size_t i = 0; i < 4; ++i) {
        std::uint32_t& number = local(vertices[i]);
        if (number == kUnused) {
          number = static_cast<std::uint32_t>(used_.size());
          used_.push_back(vertices[i]);
        }
        tet[i] = number;
      }
      part_.mesh.tets.push_back(tet);
      part_.mesh.tet_refs.push_back(regions[static_cast<std::size_t>(c - strata_.cells)]);
    }
    PetscFunctionReturn(0);
  }

  PetscErrorCode add_points() {
    DM coordinate_dm = nullptr;
    Vec coordinates = nullptr;
    IS numbering = nullptr;
    const PetscScalar* values = nullptr;
    const PetscInt* ids = nullptr;
    PetscFunctionBegin;
    PetscCall(DMGetCoordinateDM(dm_, &coordinate_dm));
    PetscCall(DMGetCoordinatesLocal(dm_, &coordinates));
    PetscCall(VecGetArrayRead(coordinates, &values));
    PetscCall(DMPlexGetVertexNumbering(dm_, &numbering));
    PetscCall(ISGetIndices(numbering, &ids));
    for (const PetscInt v : used_) {
      const PetscScalar* x = nullptr;
      PetscCall(DMPlexPointLocalRead(coordinate_dm, v, values, static_cast<void*>(&x)));
      part_.mesh.points.push_back({PetscRealPart(x[0]), PetscRealPart(x[1]), PetscRealPart(x[2])});
      const PetscInt id = ids[v - strata_.vertices];  // -(id + 1) where another rank owns the vertex
      part_.ids.push_back(static_cast<std::uint64_t>(id < 0 ? -(id + 1) : id));
    }
    PetscCall(ISRestoreIndices(numbering, &ids));
    PetscCall(VecRestoreArrayRead(coordinates, &values));
    PetscFunctionReturn(0);
  }

  /// PETSc's tets are oriented the other way round, and need not be: one of no volume is left for weft to
  /// name.
  void orient_tets() {
    for (auto& tet : part_.mesh.tets) {
      std::array<Point, 3> d;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          d[i][k] = part_.mesh.points[tet[static_cast<std::size_t>(i) + 1]][k] - part_.mesh.points[tet[0]][k];
      const double volume = d[0].x * (d[1].y * d[2].z - d[1].z * d[2].y) -
                            d[0].y * (d[1].x * d[2].z - d[1].z * d[2].x) +
                            d[0].z * (d[1].x * d[2].y - d[1].y * d[2].x);
      if (volume < 0) std::swap(tet[0], tet[1]);
    }
  }

  /// All ranks: of each point that is a face, the owned tets that it has here and on all ranks.
  PetscErrorCode count_tets(std::vector<PetscInt>& here, std::vector<PetscInt>& everywhere) const {
    PetscFunctionBegin;
    here.assign(static_cast<std::size_t>(strata_.end), 0);
    for (PetscInt f = strata_.faces; f < strata_.faces_end; ++f) {
      PetscInt size = 0;
      const PetscInt* cells = nullptr;
      PetscCall(DMPlexGetSupportSize(dm_, f, &size));
      PetscCall(DMPlexGetSupport(dm_, f, &cells));
      for (PetscInt i = 0; i < size; ++i) here[static_cast<std::size_t>(f)] += own_cell(cells[i]);
    }
    everywhere = here;
    PetscCall(combine_shared(dm_, MPI_SUM, everywhere));
    PetscFunctionReturn(0);
  }

  PetscErrorCode add_faces(DMLabel bd_label) {
    std::vector<PetscInt> here, everywhere;
    PetscFunctionBegin;
    PetscCall(count_tets(here, everywhere));
    PetscInt unset = 0;
    if (bd_label) PetscCall(DMLabelGetDefaultValue(bd_label, &unset));
    std::vector<std::int32_t> refs;
    PetscCall(references_of(dm_, bd_label, strata_.faces, strata_.faces_end, unset, refs, input_.faces));
    for (PetscInt f = strata_.faces; f < strata_.faces_end; ++f) {
      const auto at = static_cast<std::size_t>(f);
      const std::int32_t ref = refs[static_cast<std::size_t>(f - strata_.faces)];
      if (here[at] == 0 || (everywhere[at] != 1 && ref == unset)) continue;
      std::array<PetscInt, 3> vertices{};
      PetscCall(vertices_of(f, vertices));
      part_.mesh.triangles.push_back({local(vertices[0]), local(vertices[1]), local(vertices[2])});
      part_.mesh.triangle_refs.push_back(ref);
    }
    PetscFunctionReturn(0);
  }

  /// Every vertex is told the tensor of the rank that owns it: averages that a program has made of its part
  /// alone differ where parts meet.
  PetscErrorCode tensors_of_owners(std::vector<PetscReal>& tensors) const {
    PetscSF sf = nullptr, vertex_sf = nullptr;
    PetscSection section = nullptr;
    PetscInt roots = -1, *offsets = nullptr;
    PetscFunctionBegin;
    PetscCall(DMGetPointSF(dm_, &sf));
    PetscCall(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
    if (roots < 0) PetscFunctionReturn(0);
    PetscCall(PetscSectionCreate(PETSC_COMM_SELF, &section));
    PetscCall(PetscSectionSetChart(section, 0, strata_.end));
    for (PetscInt v = strata_.vertices; v < strata_.vertices_end; ++v)
      PetscCall(PetscSectionSetDof(section, v, 6));
    PetscCall(PetscSectionSetUp(section));
    PetscCall(PetscSFCreateRemoteOffsets(sf, section, section, &offsets));
    PetscCall(PetscSFCreateSectionSF(sf, section, offsets, section, &vertex_sf));
    const std::vector<PetscReal> owned = tensors;
    PetscCall(PetscSFBcastBegin(vertex_sf, MPIU_REAL, owned.data(), tensors.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(vertex_sf, MPIU_REAL, owned.data(), tensors.data(), MPI_REPLACE));
    PetscCall(PetscFree(offsets));
    PetscCall(PetscSFDestroy(&vertex_sf));
    PetscCall(PetscSectionDestroy(&section));
    PetscFunctionReturn(0);
  }

  /// All ranks: how many numbers a vertex has, 9, 1, or 0 for one that is the same everywhere.
  PetscErrorCode metric_width(Vec metric, PetscInt& width) const {
    PetscBool isotropic = PETSC_FALSE, uniform = PETSC_FALSE;
    PetscInt size = 0;
    PetscFunctionBegin;
    PetscCall(DMPlexMetricIsIsotropic(dm_, &isotropic));
    PetscCall(DMPlexMetricIsUniform(dm_, &uniform));
    PetscCall(VecGetLocalSize(metric, &size));
    width = uniform ? 0 : isotropic ? 1 : 9;
    const PetscInt wanted = uniform ? 1 : width * (strata_.vertices_end - strata_.vertices);
    std::string issue;
    if (size != wanted)
      issue = "the metric has " + std::to_string(size) + " values, not " + std::to_string(wanted) + ", " +
              std::to_string(width) + " for each of the vertices here: it must be a local vector as of " +
              "DMPlexMetricCreate()";
    PetscCall(agree(comm(), PETSC_ERR_ARG_SIZ, issue));
    PetscFunctionReturn(0);
  }

  PetscErrorCode add_metric(Vec metric) {
    PetscInt width = 0;
    const PetscScalar* values = nullptr;
    PetscFunctionBegin;
    PetscCall(metric_width(metric, width));
    std::vector<PetscReal> tensors;
    tensors.reserve(6 * local_.size());
    PetscCall(VecGetArrayRead(metric, &values));
    for (std::size_t v = 0; v < local_.size(); ++v) {
      const PetscScalar* m = values + v * static_cast<std::size_t>(width);
      for (const int i : {0, 3, 4, 6, 7, 8})  // m11 m12 m22 m13 m23 m33
        tensors.push_back(width == 9 ? PetscRealPart(m[i]) : i % 4 == 0 ? PetscRealPart(m[0]) : 0);
    }
    PetscCall(VecRestoreArrayRead(metric, &values));
    PetscCall(tensors_of_owners(tensors));
    PetscCall(take_metric(tensors));
    PetscFunctionReturn(0);
  }

  /// All ranks.
  PetscErrorCode take_metric(const std::vector<PetscReal>& tensors) {
    PetscFunctionBegin;
    std::vector<Tensor> of_used;
    of_used.reserve(used_.size());
    for (const PetscInt v : used_) {
      const PetscReal* m = tensors.data() + 6 * (v - strata_.vertices);
      of_used.push_back({m[0], m[1], m[2], m[3], m[4], m[5]});
    }
    std::string issue;
    try {
      metric_ = Metric::from_tensors(of_used);
    } catch (const std::exception& error) {
      issue = error.what();
    }
    PetscCall(agree(comm(), PETSC_ERR_ARG_WRONG, issue));
    PetscFunctionReturn(0);
  }

  DM dm_;
  PlexInput& input_;
  Part& part_;
  Metric& metric_;
  Strata strata_;
  std::vector<char> foreign_;
  std::vector<std::uint32_t> local_;  ///< number in the part of each vertex of the plex
  std::vector<PetscInt> used_;        ///< the vertices of the plex in the order of the part
};

}  // namespace

PetscErrorCode read_plex(DM dm, Vec metric, DMLabel bd_label, DMLabel rg_label, PlexInput& input) {
  PetscFunctionBegin;
  PetscCall(Reader(dm, input).read(metric, bd_label, rg_label));
  PetscFunctionReturn(0);
}

void require_boundary(Mesh& mesh) {
  mesh.required_triangles.resize(mesh.triangles.size());
  std::iota(mesh.required_triangles.begin(), mesh.required_triangles.end(), 0);
}

}  // namespace weft::petsc
