// A GeometryModel over OpenCASCADE's shapes. Everything is looked up once; afterwards only evaluations of
// Geom_Curve, Geom_Surface and Geom2d_Curve are called, which keep no state (adaptors would).
#pragma once

#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Shape.hxx>
#include <string>
#include <utility>
#include <vector>

#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

class OccModel : public GeometryModel {
 public:
  OccModel(const TopoDS_Shape& shape, std::string name, std::string unit, std::vector<std::string> warnings);

  std::span<const ModelNode> nodes() const override { return nodes_; }
  std::span<const ModelEdge> edges() const override { return edges_; }
  std::span<const ModelFace> faces() const override { return faces_; }
  CurveJet curve(std::uint32_t edge, double t) const override;
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override;
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override;
  std::size_t num_bodies() const override { return static_cast<std::size_t>(body_map_.Extent()); }
  std::vector<std::uint32_t> bodies_at(std::span<const Point> points) const override;
  const std::string& name() const override { return name_; }
  const std::string& unit() const override { return unit_; }
  std::span<const std::string> warnings() const override { return warnings_; }

  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }
  const TopoDS_Shape& shape() const { return shape_; }
  /// Ids from 1, in the order in which EGADS and refine count.
  const TopTools_IndexedMapOfShape& face_map() const { return face_map_; }
  const TopTools_IndexedMapOfShape& edge_map() const { return edge_map_; }
  const TopTools_IndexedMapOfShape& node_map() const { return node_map_; }

 private:
  void add_nodes();
  void add_edges();
  void add_faces();
  void add_border(std::uint32_t face);
  void end_loose_lines();
  template <class Evaluate>
  void evaluating(const char* kind, std::uint32_t entity, const Evaluate& evaluate) const;

  TopoDS_Shape shape_;
  std::string name_, unit_;
  std::vector<std::string> warnings_;
  TopTools_IndexedMapOfShape node_map_, edge_map_, face_map_, body_map_;
  std::vector<ModelNode> nodes_;
  std::vector<ModelEdge> edges_;
  std::vector<ModelFace> faces_;
  std::vector<Handle(Geom_Curve)> curves_;
  std::vector<Handle(Geom_Surface)> surfaces_;
  std::vector<std::vector<Handle(Geom2d_Curve)>> pcurves_;  // face -> of its border
};

}  // namespace weft::meshing
