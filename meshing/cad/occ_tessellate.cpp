// Joins the triangulations that OpenCASCADE makes of faces at the points of their common edges.
#include "meshing/cad/occ_tessellate.h"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <Precision.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/cad/lay_triangles.h"

namespace weft::meshing {
namespace {

class Joiner {
 public:
  explicit Joiner(const OccModel& model) : model_(model) {}

  MeshData run() {
    for (std::uint32_t n = 0; n < model_.nodes().size(); ++n) {
      const std::uint32_t v = add_point(model_.nodes()[n].x);
      mesh_.corners.push_back(v);
      mesh_.association.nodes.push_back({v, static_cast<std::int32_t>(n + 1)});
    }
    edge_points_.resize(model_.edges().size());
    for (int f = 1; f <= model_.face_map().Extent(); ++f) add_face(f);
    list_edges();
    drop_unused_points();
    refuse_open();
    mesh_.point_refs.assign(mesh_.points.size(), 0);
    return std::move(mesh_);
  }

 private:
  std::uint32_t add_point(const Point& p) {
    mesh_.points.push_back(p);
    return static_cast<std::uint32_t>(mesh_.points.size() - 1);
  }

  /// The points of an edge between its nodes, which the first face that comes by makes.
  const std::vector<std::uint32_t>& points_of(std::uint32_t e,
                                              const Handle(Poly_PolygonOnTriangulation) & line,
                                              const std::string& face) {
    std::vector<std::uint32_t>& points = edge_points_[e];
    const ModelEdge& edge = model_.edges()[e];
    const int n = line->NbNodes();
    if (points.empty() && !edge.degenerate) {
      points.push_back(edge.nodes[0]);
      for (int i = 2; i < n; ++i) {
        const double t = line->Parameter(i);
        points.push_back(add_point(model_.curve(e, t).x));
        mesh_.association.edges.push_back(
            {points.back(), static_cast<std::int32_t>(e + 1), t, static_cast<double>(e + 1)});
      }
      points.push_back(edge.nodes[1]);
    }
    if (!edge.degenerate && points.size() != static_cast<std::size_t>(n))
      throw InputError(model_.name(), face + ", edge " + std::to_string(e + 1),
                       "is divided otherwise than on the face beside it: not watertight");
    return points;
  }

  void place_edge(const TopoDS_Edge& edge, const TopLoc_Location& place,
                  const Handle(Poly_Triangulation) & triangles, const std::string& face,
                  std::vector<std::uint32_t>& number) {
    const Handle(Poly_PolygonOnTriangulation) line =
        BRep_Tool::PolygonOnTriangulation(edge, triangles, place);
    const auto e = static_cast<std::uint32_t>(model_.edge_map().FindIndex(edge) - 1);
    if (line.IsNull())
      throw InputError(model_.name(), face + ", edge " + std::to_string(e + 1), "could not be divided");
    const std::vector<std::uint32_t>& points = points_of(e, line, face);
    for (int i = 1; i <= line->NbNodes(); ++i) {
      const auto local = static_cast<std::size_t>(line->Node(i) - 1);
      number[local] =
          model_.edges()[e].degenerate ? model_.edges()[e].nodes[0] : points[static_cast<std::size_t>(i - 1)];
    }
  }

  void add_face(int id) {
    const TopoDS_Face& face = TopoDS::Face(model_.face_map()(id));
    const std::string name = "face " + std::to_string(id);
    TopLoc_Location place;
    const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, place);
    if (triangles.IsNull() || triangles->NbTriangles() == 0)
      throw InputError(model_.name(), name, "could not be tessellated");
    std::vector<std::uint32_t> number(static_cast<std::size_t>(triangles->NbNodes()), kNoEntity);
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next())
      place_edge(TopoDS::Edge(at.Current()), place, triangles, name, number);
    for (int i = 1; i <= triangles->NbNodes(); ++i) {
      std::uint32_t& v = number[static_cast<std::size_t>(i - 1)];
      if (v != kNoEntity) continue;
      const gp_Pnt2d uv = triangles->UVNode(i);
      v = add_point(model_.surface(static_cast<std::uint32_t>(id - 1), {uv.X(), uv.Y()}).x);
      mesh_.association.faces.push_back({v, id, uv.X(), uv.Y(), static_cast<double>(id)});
    }
    const bool turned = face.Orientation() == TopAbs_REVERSED;
    std::vector<FaceTriangle> of_face;
    for (int i = 1; i <= triangles->NbTriangles(); ++i) {
      int a, b, c;
      triangles->Triangle(i).Get(a, b, c);
      if (turned) std::swap(b, c);
      const auto of = [&](int k) { return number[static_cast<std::size_t>(k - 1)]; };
      const auto at = [&](int k) {
        const gp_Pnt2d uv = triangles->UVNode(k);
        return Parameters{uv.X(), uv.Y()};
      };
      if (of(a) == of(b) || of(b) == of(c) || of(c) == of(a)) continue;  // upon a pole
      of_face.push_back({{of(a), of(b), of(c)}, {at(a), at(b), at(c)}});
    }
    lay_down(static_cast<std::uint32_t>(id - 1), of_face);
    for (const FaceTriangle& t : of_face) {
      mesh_.triangles.push_back(t.v);
      mesh_.triangle_refs.push_back(id);
    }
  }

  void lay_down(std::uint32_t face, std::vector<FaceTriangle>& triangles) const {
    std::set<VertexPair> fixed;
    std::set<std::uint32_t> poles;
    for (const EdgeUse& use : model_.faces()[face].border) {
      const std::vector<std::uint32_t>& points = edge_points_[use.edge];
      for (std::size_t i = 0; i + 1 < points.size(); ++i) fixed.insert(std::minmax(points[i], points[i + 1]));
      if (model_.edges()[use.edge].degenerate) poles.insert(model_.edges()[use.edge].nodes[0]);
    }
    lay_triangles(model_, face, mesh_.points, fixed, poles, triangles);
  }

  void list_edges() {
    for (std::uint32_t e = 0; e < edge_points_.size(); ++e)
      for (std::size_t i = 0; i + 1 < edge_points_[e].size(); ++i) {
        mesh_.ridges.push_back(static_cast<std::uint32_t>(mesh_.edges.size()));
        mesh_.edges.push_back({edge_points_[e][i], edge_points_[e][i + 1]});
        mesh_.edge_refs.push_back(static_cast<std::int32_t>(e + 1));
      }
  }

  /// Nodes of wires beside the body.
  void drop_unused_points() {
    std::vector<std::uint32_t> number(mesh_.points.size(), kNoEntity);
    for (const auto& t : mesh_.triangles)
      for (const std::uint32_t v : t) number[v] = 0;
    std::vector<Point> points;
    for (std::uint32_t v = 0; v < number.size(); ++v)
      if (number[v] == 0) {
        number[v] = static_cast<std::uint32_t>(points.size());
        points.push_back(mesh_.points[v]);
      }
    if (points.size() == mesh_.points.size()) return;
    const auto gone = [&](std::uint32_t v) { return number[v] == kNoEntity; };
    std::erase_if(mesh_.corners, gone);
    std::erase_if(mesh_.association.nodes, [&](const auto& r) { return gone(r.vertex); });
    for (std::uint32_t& v : mesh_.corners) v = number[v];
    for (auto& r : mesh_.association.nodes) r.vertex = number[r.vertex];
    for (auto& r : mesh_.association.edges) r.vertex = number[r.vertex];
    for (auto& r : mesh_.association.faces) r.vertex = number[r.vertex];
    for (auto& t : mesh_.triangles)
      for (std::uint32_t& v : t) v = number[v];
    MeshData kept;
    for (std::size_t i = 0; i < mesh_.edges.size(); ++i) {
      const auto [a, b] = mesh_.edges[i];
      if (gone(a) || gone(b)) continue;
      kept.ridges.push_back(static_cast<std::uint32_t>(kept.edges.size()));
      kept.edges.push_back({number[a], number[b]});
      kept.edge_refs.push_back(mesh_.edge_refs[i]);
    }
    mesh_.edges = std::move(kept.edges);
    mesh_.edge_refs = std::move(kept.edge_refs);
    mesh_.ridges = std::move(kept.ridges);
    mesh_.points = std::move(points);
  }

  /// Every edge of a closed surface has two triangles, or four where bodies touch.
  void refuse_open() const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, std::int32_t>> seen;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = mesh_.triangles[t][i], b = mesh_.triangles[t][(i + 1) % 3];
        auto& [count, ref] = seen[std::minmax(a, b)];
        ++count;
        ref = mesh_.triangle_refs[t];
      }
    for (const auto& [edge, count] : seen) {
      if (count.first > 1) continue;
      const auto on = std::ranges::find_if(mesh_.edges, [&](const auto& e) {
        return std::minmax(e[0], e[1]) == std::minmax(edge.first, edge.second);
      });
      std::string where = "face " + std::to_string(count.second);
      if (on != mesh_.edges.end())
        where +=
            ", edge " + std::to_string(mesh_.edge_refs[static_cast<std::size_t>(on - mesh_.edges.begin())]);
      throw InputError(model_.name(), where,
                       is_beside_bodies(count.second)
                           ? "belongs to no body: remove it from the model, or let it be one's boundary"
                           : "the surface is open here: a face is missing or not joined");
    }
  }

  /// A sheet, for instance what a body was swept from, in a model that has bodies.
  bool is_beside_bodies(int face) const {
    TopTools_IndexedMapOfShape of_bodies;
    for (TopExp_Explorer at(model_.shape(), TopAbs_SOLID); at.More(); at.Next())
      TopExp::MapShapes(at.Current(), TopAbs_FACE, of_bodies);
    return !of_bodies.IsEmpty() && !of_bodies.Contains(model_.face_map()(face));
  }

  const OccModel& model_;
  MeshData mesh_;
  std::vector<std::vector<std::uint32_t>> edge_points_;
};

void tessellate(const TopoDS_Shape& shape, double sagitta, double angle_degrees) {
  // OpenCASCADE takes no sagitta below that; of tiny models the angle alone counts then.
  BRepMesh_IncrementalMesh(shape, std::max(sagitta, Precision::Confusion()), Standard_False,
                           angle_degrees * std::numbers::pi / 180, Standard_False);
}

using SagittaOfFace = std::pair<double, int>;

/// Where less than that of all is asked for, the finest first: the others then take its points on the edges
/// between them.
std::vector<SagittaOfFace> finer_faces(const CadTessellation& options) {
  std::vector<SagittaOfFace> finer;
  for (std::size_t f = 0; f < options.face_sagittas.size(); ++f)
    if (options.face_sagittas[f] < options.sagitta)
      finer.emplace_back(options.face_sagittas[f], static_cast<int>(f) + 1);
  std::sort(finer.begin(), finer.end());
  return finer;
}

}  // namespace

MeshData tessellate_occ(const OccModel& model, const CadTessellation& options) {
  const std::vector<SagittaOfFace> finer = finer_faces(options);
  BRepTools::Clean(model.shape());
  for (const auto& [sagitta, face] : finer)
    tessellate(model.face_map()(face), sagitta, options.angle_degrees);
  tessellate(model.shape(), options.sagitta, options.angle_degrees);
  if (finer.empty()) return Joiner(model).run();
  try {
    return Joiner(model).run();
  } catch (const InputError&) {
    // A face that comes later may divide an edge anew, though it is fine enough; not so where all are
    // tessellated at once.
    constexpr double kFinest = 1.0 / 16;
    BRepTools::Clean(model.shape());
    tessellate(model.shape(), std::max(finer.front().first, kFinest * options.sagitta),
               options.angle_degrees);
    return Joiner(model).run();
  }
}

}  // namespace weft::meshing
