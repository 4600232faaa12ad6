// Models through OpenCASCADE: files of all formats, ids, units, parameters, damaged files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Writer.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gp_Circ.hxx>
#include <gp_Lin.hxx>
#include <gp_Pln.hxx>
#include <map>
#include <numbers>

#include "meshing/base/error.h"
#include "meshing/cad/check_model.h"
#include "meshing/cad/load_model.h"
#include "meshing/geometry/model/model.h"
#include "meshing/initial/closed_surface.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/mesh/check_mesh.h"

namespace weft::meshing::occ_model_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A cube of side 1 with a hole of radius 0.3 through it along z.
TopoDS_Shape pierced_cube() {
  const TopoDS_Shape cube = BRepPrimAPI_MakeBox(1, 1, 1).Shape();
  const gp_Ax2 axis(gp_Pnt(0.5, 0.5, -1), gp_Dir(0, 0, 1));
  return BRepAlgoAPI_Cut(cube, BRepPrimAPI_MakeCylinder(axis, 0.3, 3).Shape()).Shape();
}

class OccModels : public testing::Test {
 protected:
  OccModels()
      : folder_(fs::temp_directory_path() / ("weft_occ_" + std::to_string(getpid()) + "_" +
                                             testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::create_directories(folder_);
  }
  ~OccModels() override { fs::remove_all(folder_); }

  std::string brep(const TopoDS_Shape& shape) {
    const std::string path = (folder_ / "model.brep").string();
    BRepTools::Write(shape, path.c_str());
    return path;
  }
  std::string step(const TopoDS_Shape& shape, const char* unit) {
    const std::string path = (folder_ / "model.step").string();
    STEPControl_Writer writer;
    Interface_Static::SetCVal("write.step.unit", unit);
    writer.Transfer(shape, STEPControl_AsIs);
    writer.Write(path.c_str());
    return path;
  }

  fs::path folder_;
};

void expect_pierced_cube(const Model& model) {
  EXPECT_EQ(model.num_faces(), 7u);
  EXPECT_NEAR(model.size(), std::sqrt(3.0), 1e-6);
  int tubes = 0;
  for (std::uint32_t f = 0; f < model.num_faces(); ++f) {
    if (model.face(f).form.kind != SurfaceForm::Kind::cylinder) continue;
    ++tubes;
    EXPECT_NEAR(model.closest_within(f, {0.5, 0.5, 0.5}).distance, 0.3, 1e-12);
  }
  EXPECT_EQ(tubes, 1);
}

TEST_F(OccModels, AreReadFromBrep) { expect_pierced_cube(Model(load_model(brep(pierced_cube())))); }

TEST_F(OccModels, OfStepKeepTheNumbersOfTheirUnitAndNameIt) {
  // OpenCASCADE takes the shape's numbers as millimetres.
  const auto millimetres = load_model(step(pierced_cube(), "MM"));
  EXPECT_EQ(millimetres->unit(), "millimetre");
  expect_pierced_cube(Model(millimetres));
  const std::string path = step(pierced_cube(), "MM");
  std::ifstream in(path);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t unit = text.find("SI_UNIT(.MILLI.,.METRE.)");
  ASSERT_NE(unit, std::string::npos);
  std::ofstream(path) << text.replace(unit, 24, "SI_UNIT($,.METRE.)");
  const auto metres = load_model(path);
  EXPECT_EQ(metres->unit(), "metre");
  expect_pierced_cube(Model(metres));
}

TEST_F(OccModels, AreReadFromIges) {
  const std::string path = (folder_ / "model.igs").string();
  IGESControl_Writer writer("MM", 1);
  writer.AddShape(pierced_cube());
  writer.ComputeModel();
  writer.Write(path.c_str());
  const Model model(load_model(path));
  EXPECT_EQ(model.geometry().unit(), "millimetre");
  EXPECT_NEAR(model.size(), std::sqrt(3.0), 1e-5);
  EXPECT_GE(model.num_faces(), 7u);
}

/// A file's unit is told by a flag; its name may be missing.
TEST_F(OccModels, OfIgesWithoutANameOfTheirUnitKeepItsNumbers) {
  const std::string path = (folder_ / "model.igs").string();
  IGESControl_Writer writer("IN", 1);
  writer.AddShape(pierced_cube());  // of millimetres
  writer.ComputeModel();
  writer.Write(path.c_str());
  std::ifstream in(path);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto at = text.find(",1,4HINCH,");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 10, ",1,,      ");  // as long as before: lines have 80 columns
  std::ofstream(path) << text;
  const Model model(load_model(path));
  EXPECT_EQ(model.geometry().unit(), "inch");
  EXPECT_NEAR(model.size(), std::sqrt(3.0) / 25.4, 1e-5);
}

/// Sketches, axes and points of construction.
TEST_F(OccModels, WithWiresAndPointsBesideTheirBodyAreAsLargeAsIt) {
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  builder.Add(all, pierced_cube());
  builder.Add(all, BRepBuilderAPI_MakeEdge(gp_Lin(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Edge());
  builder.Add(all, BRepBuilderAPI_MakeEdge(gp_Pnt(50, 0, 0), gp_Pnt(80, 0, 0)).Edge());
  builder.Add(all, BRepBuilderAPI_MakeVertex(gp_Pnt(1e4, 0, 0)).Vertex());
  const Model model(load_model(brep(all)));
  EXPECT_EQ(model.num_faces(), 7u);
  EXPECT_NEAR(model.size(), std::sqrt(3.0), 1e-6);
}

/// As Boolean operations imprint them.
TEST_F(OccModels, WithEdgesWithinAFaceAreWhole) {
  TopoDS_Face face = BRepBuilderAPI_MakeFace(gp_Pln(), 0, 1, 0, 1).Face();
  BRep_Builder builder;
  for (const TopoDS_Edge& edge :
       {BRepBuilderAPI_MakeEdge(gp_Pnt(.2, .2, 0), gp_Pnt(.4, .2, 0)).Edge(),
        BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(gp_Pnt(.6, .6, 0), gp_Dir(0, 0, 1)), .2)).Edge()}) {
    TopoDS_Wire wire;
    builder.MakeWire(wire);
    builder.Add(wire, edge.Oriented(TopAbs_INTERNAL));
    builder.Add(face, wire);
  }
  TopoDS_Shell shell;
  builder.MakeShell(shell);
  builder.Add(shell, face);
  const Model model(load_model(brep(shell)));
  EXPECT_EQ(model.num_edges(), 6u);
  EXPECT_EQ(model.face(0).border.size(), 8u) << "both on two sides";
  for (const Point& p : {Point{.6, .6, .3}, Point{.1, .6, .3}})
    EXPECT_NEAR(norm(model.closest_within(0, p).x - Point{p.x, p.y, 0}), 0, 1e-12);
}

TEST_F(OccModels, OfEgadsAreBrepWithAHeader) {
  const std::string path = brep(pierced_cube());
  std::ofstream(path, std::ios::app)
      << "##EGADS HEADER FILE-REV 1 ##\n0\n  1  1  7  7  15  10  0\n    0 0 0\n";
  const std::string egads = (folder_ / "model.egads").string();
  fs::rename(path, egads);
  expect_pierced_cube(Model(load_model(egads)));
}

TEST_F(OccModels, ThatAreDamagedAreRefusedByName) {
  const std::string path = step(pierced_cube(), "MM");
  std::ifstream in(path);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  std::ofstream(path) << text.substr(0, text.size() / 6);
  try {
    load_model(path);
    FAIL() << "a truncated file was read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("model.step"));
    EXPECT_THAT(error.what(), HasSubstr("truncated"));
  }
  const std::string other = brep(pierced_cube());
  std::ifstream brep_in(other);
  std::string brep_text((std::istreambuf_iterator<char>(brep_in)), {});
  std::ofstream(other) << brep_text.substr(0, brep_text.size() / 2);
  EXPECT_THROW(load_model(other), InputError);
  EXPECT_THROW(load_model((folder_ / "none.step").string()), InputError);
  EXPECT_THROW(load_model((folder_ / "none.txt").string()), InputError);
}

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The entities of a STEP file, as they begin in its text.
std::vector<std::size_t> entities_of(const std::string& text) {
  std::vector<std::size_t> all;
  for (std::size_t at = text.find("\n#"); at != std::string::npos; at = text.find("\n#", at + 1))
    all.push_back(at + 1);
  return all;
}

std::string without_entity(std::string text, std::size_t at) {
  return text.erase(at, text.find(";\n", at) + 2 - at);
}

/// Why a model is refused; empty where it is read.
std::string refusal_of(const std::string& path) {
  try {
    load_model(path);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST_F(OccModels, WithAnEntityOfTheFileMissingAreReadOrRefusedAndNeverCrash) {
  // Of OpenCASCADE's readers one in four of these ends in a segmentation fault.
  const std::string path = step(pierced_cube(), "MM"), whole = text_of(path);
  std::size_t refused = 0, crashed = 0, tried = 0;
  const std::vector<std::size_t> entities = entities_of(whole);
  for (std::size_t i = 3; i < entities.size(); i += 9, ++tried) {
    std::ofstream(path) << without_entity(whole, entities[i]);
    const std::string why = refusal_of(path);
    refused += !why.empty();
    crashed += why.find("crashes") != std::string::npos;
    if (!why.empty()) {
      EXPECT_THAT(why, HasSubstr("model.step"));
    }
  }
  EXPECT_GT(tried, 30u);
  EXPECT_GT(refused, 5u);
  EXPECT_GT(crashed, 0u);
}

TEST_F(OccModels, ThatAMeshCarriesSayWhyTheyCannotBeRead) {
  Association association;
  const std::string whole = text_of(brep(pierced_cube()));
  association.model.assign(whole.begin(), whole.end());
  expect_pierced_cube(Model(load_carried_model(association, "mesh.meshb")));
  association.model.resize(whole.size() / 2);
  try {
    load_carried_model(association, "mesh.meshb");
    FAIL() << "half a model was read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("mesh.meshb: ByteFlow: "));
    EXPECT_THAT(error.what(), HasSubstr("is no BREP file, or is damaged or truncated"));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("/weft-")));  // where it was for the moment
  }
}

TEST_F(OccModels, WithoutTheCurveOfAnEdgeAreRefusedByFaceAndEntity) {
  const std::string path = step(pierced_cube(), "MM"), whole = text_of(path);
  // The first curve of a SURFACE_CURVE or an EDGE_CURVE on a line is the one in space.
  const std::size_t line = whole.find(" = LINE(");
  ASSERT_NE(line, std::string::npos);
  std::ofstream(path) << without_entity(whole, whole.rfind('#', line));
  EXPECT_THAT(refusal_of(path),
              testing::AllOf(HasSubstr("the model is damaged"), HasSubstr("entities of the file")));
}

TEST_F(OccModels, WithoutOneFaceTellWhereTheyAreOpen) {
  const std::string path = step(pierced_cube(), "MM"), whole = text_of(path);
  const std::size_t face = whole.find(" = ADVANCED_FACE(");
  ASSERT_NE(face, std::string::npos);
  std::ofstream(path) << without_entity(whole, whole.rfind('#', face));
  const auto model = load_model(path);
  const auto warnings = model->warnings();
  EXPECT_THAT(warnings, testing::Contains(HasSubstr("the model is open at edge")));
  EXPECT_THAT(warnings, testing::Contains(HasSubstr("entities of the file")));
}

/// A model of which something may be changed.
class Damaged : public GeometryModel {
 public:
  explicit Damaged(std::shared_ptr<const GeometryModel> whole)
      : node_list(whole->nodes().begin(), whole->nodes().end()),
        edge_list(whole->edges().begin(), whole->edges().end()),
        face_list(whole->faces().begin(), whole->faces().end()),
        whole_(std::move(whole)) {}
  std::span<const ModelNode> nodes() const override { return node_list; }
  std::span<const ModelEdge> edges() const override { return edge_list; }
  std::span<const ModelFace> faces() const override { return face_list; }
  CurveJet curve(std::uint32_t edge, double t) const override { return whole_->curve(edge, t); }
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override {
    SurfaceJet jet = whole_->surface(face, at);
    jet.x.x += face == 0 ? first_face_off : 0;
    return jet;
  }
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override {
    return whole_->on_face(face, use, t);
  }
  const std::string& name() const override { return whole_->name(); }
  const std::string& unit() const override { return whole_->unit(); }
  std::span<const std::string> warnings() const override { return {}; }

  std::vector<ModelNode> node_list;
  std::vector<ModelEdge> edge_list;
  std::vector<ModelFace> face_list;
  double first_face_off = 0;

 private:
  std::shared_ptr<const GeometryModel> whole_;
};

TEST_F(OccModels, AreCheckedEntityByEntity) {
  const auto whole = load_model(step(pierced_cube(), "MM"));
  const auto fatal = [&](const auto& damage) {
    Damaged model(whole);
    damage(model);
    return defects_of(model).fatal;
  };
  using testing::Contains;
  EXPECT_TRUE(fatal([](Damaged&) {}).empty());
  EXPECT_TRUE(defects_of(*whole).slight.empty());
  EXPECT_THAT(fatal([](Damaged& m) { m.node_list[2].x.x = std::nan(""); }), Contains(HasSubstr("node 3")));
  EXPECT_THAT(fatal([](Damaged& m) { m.node_list[2].x.x += 0.1; }), Contains(HasSubstr("end at its node 3")));
  EXPECT_THAT(fatal([](Damaged& m) { m.node_list[2].tolerance = 0.5; }),
              Contains(HasSubstr("node 3 is known")));
  EXPECT_THAT(fatal([](Damaged& m) { m.edge_list[4].end = 2e100; }),
              Contains(HasSubstr("edge 5 has no ends")));
  EXPECT_THAT(fatal([](Damaged& m) { m.face_list[1].lo[0] = -2e100; }),
              Contains(HasSubstr("face 2 is not bounded")));
  EXPECT_THAT(fatal([](Damaged& m) { m.face_list[1].border.pop_back(); }),
              Contains(HasSubstr("border of face 2 is not closed")));
  EXPECT_THAT(fatal([](Damaged& m) { m.first_face_off = 0.1; }),
              Contains(HasSubstr("does not lie on its face 1")));
  Damaged model(whole);
  model.first_face_off = 1e-4;
  EXPECT_TRUE(defects_of(model).fatal.empty());
  EXPECT_THAT(defects_of(model).slight, Contains(HasSubstr("does not lie on its face 1")));
}

/// Evaluation along borders: of a face's surface at an edge's place on it is the edge's curve.
void expect_borders_to_fit(const Model& model, double tolerance) {
  for (std::uint32_t f = 0; f < model.num_faces(); ++f)
    for (const EdgeUse& use : model.face(f).border) {
      const ModelEdge& e = model.edge(use.edge);
      for (int i = 0; i <= 10; ++i) {
        const double t = e.begin + (e.end - e.begin) * i / 10;
        const Point on_face = model.surface(f, model.geometry().on_face(f, use, t)).x;
        const Point on_edge = e.degenerate ? model.node(e.nodes[0]) : model.curve(use.edge, t).x;
        EXPECT_NEAR(norm(on_face - on_edge), 0, tolerance) << "face " << f + 1 << " edge " << use.edge + 1;
      }
      if (e.degenerate) continue;
      EXPECT_NEAR(norm(model.curve(use.edge, e.begin).x - model.node(e.nodes[0])), 0, tolerance);
      EXPECT_NEAR(norm(model.curve(use.edge, e.end).x - model.node(e.nodes[1])), 0, tolerance);
    }
}

TEST_F(OccModels, HaveBordersWhereTheirEdgesAre) {
  for (const TopoDS_Shape& shape :
       {pierced_cube(), BRepPrimAPI_MakeSphere(2).Shape(), BRepPrimAPI_MakeCone(1, 0, 2).Shape(),
        BRepPrimAPI_MakeTorus(2, 0.5).Shape(), BRepBuilderAPI_NurbsConvert(pierced_cube()).Shape(),
        BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeSphere(2).Shape()).Shape()})
    expect_borders_to_fit(Model(load_model(brep(shape))), 1e-6);
}

TEST_F(OccModels, OfSplinesFindTheClosestPointsOfTheFormulas) {
  const Model exact(load_model(brep(BRepPrimAPI_MakeSphere(2).Shape())));
  const Model spline(
      load_model(brep(BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeSphere(2).Shape()).Shape())));
  EXPECT_TRUE(exact.has_formula(0));
  EXPECT_FALSE(spline.has_formula(0));
  for (int i = 0; i < 200; ++i) {
    const Point p{std::sin(1.0 * i), std::cos(2.7 * i), 3 * std::sin(0.3 * i)};
    EXPECT_NEAR(spline.closest_on_face(0, p).distance, exact.closest_on_face(0, p).distance, 1e-9);
  }
  for (const Point& pole : {Point{0, 0, 2}, Point{0, 0, -2.5}, Point{1e-8, 1e-8, 2.1}})
    EXPECT_NEAR(spline.closest_on_face(0, pole).distance, std::abs(norm(pole) - 2), 1e-9);
}

/// The model's own evaluation of splines against OpenCASCADE's, within and at knots, and beyond a period.
void expect_evaluation_of_opencascade(const Model& model) {
  const GeometryModel& occ = model.geometry();
  const auto expect_near = [&](const Vec& a, const Vec& b, double speed) {
    EXPECT_NEAR(norm(a - b), 0, 1e-13 * std::max(speed, model.size()));
  };
  for (std::uint32_t f = 0; f < model.num_faces(); ++f) {
    const ModelFace& m = model.face(f);
    if (!m.spline) continue;
    for (int i = 0; i <= 24; ++i)
      for (int j = 0; j <= 24; ++j) {
        Parameters at{m.lo[0] + (m.hi[0] - m.lo[0]) * i / 24, m.lo[1] + (m.hi[1] - m.lo[1]) * j / 24};
        for (std::size_t k = 0; k < 2; ++k)
          if (i % 3 == 1) at[k] += 2 * m.period[k];
        const SurfaceJet a = model.surface(f, at), b = occ.surface(f, at);
        const double speed = std::max(norm(b.du), norm(b.dv));
        expect_near(a.x, b.x, 0);
        expect_near(a.du, b.du, 10 * speed);
        expect_near(a.dv, b.dv, 10 * speed);
        // At knots second derivatives may be those of either side.
        if (i % 2 == 0 || j % 2 == 0) continue;
        const double bend = std::max({norm(b.duu), norm(b.duv), norm(b.dvv), speed});
        expect_near(a.duu, b.duu, 100 * bend);
        expect_near(a.duv, b.duv, 100 * bend);
        expect_near(a.dvv, b.dvv, 100 * bend);
      }
  }
  for (std::uint32_t e = 0; e < model.num_edges(); ++e) {
    const ModelEdge& m = model.edge(e);
    if (!m.spline) continue;
    for (int i = 0; i <= 24; ++i) {
      const double t = m.begin + (m.end - m.begin) * i / 24 + (i % 3 == 1 ? m.period : 0);
      const CurveJet a = model.curve(e, t), b = occ.curve(e, t);
      expect_near(a.x, b.x, 0);
      expect_near(a.d1, b.d1, 10 * norm(b.d1));
      if (i % 2 == 1) expect_near(a.d2, b.d2, 100 * std::max(norm(b.d1), norm(b.d2)));
    }
  }
}

/// Circles of different radii, one above the other: a smooth surface through them.
TopoDS_Shape loft() {
  BRepOffsetAPI_ThruSections through(true, false, 1e-6);
  for (const double z : {0.0, 1.0, 2.0, 3.0}) {
    const gp_Circ circle(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), 1 - 0.3 * std::sin(2 * z));
    through.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle)));
  }
  through.Build();
  return through.Shape();
}

TEST_F(OccModels, OfSplinesAreEvaluatedAsByOpenCascade) {
  for (const TopoDS_Shape& shape :
       {loft(), BRepBuilderAPI_NurbsConvert(pierced_cube()).Shape(),
        BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeSphere(2).Shape()).Shape(),
        BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeTorus(2, 0.5).Shape()).Shape()}) {
    const Model model(load_model(brep(shape)));
    EXPECT_TRUE(std::any_of(model.geometry().faces().begin(), model.geometry().faces().end(),
                            [](const ModelFace& f) { return f.spline.has_value(); }));
    expect_evaluation_of_opencascade(model);
  }
}

/// A tube of six by two control points whose parameter goes round.
TopoDS_Shape periodic_face() {
  TColgp_Array2OfPnt poles(1, 6, 1, 2);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 2; ++j) poles(i + 1, j + 1) = gp_Pnt(std::cos(i * 1.047), std::sin(i * 1.047), j);
  TColStd_Array1OfReal round(1, 7), along(1, 2);
  TColStd_Array1OfInteger once(1, 7), twice(1, 2);
  for (int i = 0; i < 7; ++i) round(i + 1) = i, once(i + 1) = 1;
  for (int j = 0; j < 2; ++j) along(j + 1) = j, twice(j + 1) = 2;
  const Handle(Geom_BSplineSurface) tube =
      new Geom_BSplineSurface(poles, round, along, once, twice, 2, 1, Standard_True, Standard_False);
  return BRepBuilderAPI_MakeFace(tube, 1e-6);
}

TEST_F(OccModels, OfPeriodicSplinesWithoutWeightsAreEvaluatedToo) {
  const Model model(load_model(brep(periodic_face())));
  ASSERT_TRUE(model.geometry().faces()[0].spline.has_value());
  EXPECT_GT(model.face(0).period[0], 0);
  expect_evaluation_of_opencascade(model);
}

/// Each edge of two triangles, and the Euler number.
void expect_closed(const MeshData& mesh, int euler) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++sides[std::minmax(t[i], t[(i + 1) % 3])];
  for (const auto& [edge, count] : sides) EXPECT_EQ(count, 2);
  EXPECT_EQ(static_cast<int>(mesh.points.size() + mesh.triangles.size()) - static_cast<int>(sides.size()),
            euler);
}

TEST_F(OccModels, AreTessellatedWithoutGaps) {
  const std::map<std::string, std::pair<TopoDS_Shape, int>> bodies = {
      {"cube", {pierced_cube(), 0}},
      {"sphere", {BRepPrimAPI_MakeSphere(2).Shape(), 2}},
      {"cone", {BRepPrimAPI_MakeCone(1, 0, 2).Shape(), 2}},
      {"torus", {BRepPrimAPI_MakeTorus(2, 0.5).Shape(), 0}}};
  for (const auto& [name, body] : bodies) {
    SCOPED_TRACE(name);
    const std::string path = brep(body.first);
    const auto geometry = load_model(path);
    const MeshData mesh = tessellate_model(path, *geometry, {0.01, 20});
    expect_closed(mesh, body.second);
    const Model model(geometry);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      for (const std::uint32_t v : mesh.triangles[i])
        EXPECT_NEAR(
            model.closest_within(static_cast<std::uint32_t>(mesh.triangle_refs[i] - 1), mesh.points[v])
                .distance,
            0, 1e-9);
  }
}

TEST_F(OccModels, WithSmallBodiesInLargeDomainsHaveTrianglesBySizeOfFace) {
  // A lens, 2 wide and 0.1 thick, in a box of which 0.1 % is more than that.
  const TopoDS_Shape lens = BRepAlgoAPI_Common(BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, -9.95), 10).Shape(),
                                               BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 9.95), 10).Shape())
                                .Shape();
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(gp_Pnt(-50, -50, -50), gp_Pnt(50, 50, 50)).Shape();
  const std::string path = brep(BRepAlgoAPI_Cut(box, lens).Shape());
  const auto geometry = load_model(path);
  const Model model(geometry);
  CadTessellation options{0.17, 20, {}};
  for (std::uint32_t f = 0; f < model.num_faces(); ++f) options.face_sagittas.push_back(model.detail(f));
  const MeshData mesh = tessellate_model(path, *geometry, options);
  int on_lens = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto f = static_cast<std::uint32_t>(mesh.triangle_refs[t] - 1);
    if (model.face(f).form.kind != SurfaceForm::Kind::sphere) continue;
    ++on_lens;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point middle =
          midpoint(mesh.points[mesh.triangles[t][i]], mesh.points[mesh.triangles[t][(i + 1) % 3]]);
      EXPECT_LT(model.closest_on_face(f, middle).distance, 0.006);
    }
  }
  EXPECT_GT(on_lens, 20);
}

CadTessellation with_details(const Model& model) {
  CadTessellation options{0.001 * model.size(), 20, {}};
  for (std::uint32_t f = 0; f < model.num_faces(); ++f) options.face_sagittas.push_back(model.detail(f));
  return options;
}

/// OpenCASCADE divides common edges of faces that are tessellated one after the other otherwise, here and
/// there.
TEST_F(OccModels, WithDetailsOnAllFacesAreTessellatedWithoutGaps) {
  const auto along = [](const gp_Dir& way, double radius) {
    const gp_Pnt begin(-way.X(), -way.Y(), -way.Z());
    return BRepPrimAPI_MakeCylinder(gp_Ax2(begin, way), radius, 2).Shape();
  };
  const TopoDS_Shape two = BRepAlgoAPI_Fuse(along({1, 0, 0}, 0.3), along({0, 1, 0}, 0.3)).Shape();
  const std::string path = brep(BRepAlgoAPI_Fuse(two, along({0, 0, 1}, 0.25)).Shape());
  const auto geometry = load_model(path);
  expect_closed(tessellate_model(path, *geometry, with_details(Model(geometry))), 2);
}

/// In a STEP file each has faces of its own.
TEST_F(OccModels, OfBodiesThatTouchHaveCommonFaces) {
  BRep_Builder builder;
  TopoDS_Compound bodies;
  builder.MakeCompound(bodies);
  builder.Add(bodies, BRepPrimAPI_MakeBox(1, 1, 1).Shape());
  builder.Add(bodies, BRepPrimAPI_MakeBox(gp_Pnt(1, 0, 0), gp_Pnt(2, 1, 1)).Shape());
  builder.Add(bodies, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(1, 0.5, 1), gp_Dir(0, 0, 1)), 0.3, 1).Shape());
  const std::string path = step(bodies, "MM");
  const auto geometry = load_model(path);
  EXPECT_EQ(geometry->num_bodies(), 3u);
  EXPECT_THAT(geometry->warnings(), testing::Contains(HasSubstr("bodies touch")));
  const MeshData mesh = tessellate_model(path, *geometry, with_details(Model(geometry)));
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++sides[std::minmax(t[i], t[(i + 1) % 3])];
  int at_three = 0;
  for (const auto& [edge, count] : sides) {
    EXPECT_GE(count, 2);
    at_three += count == 3;
  }
  EXPECT_GT(at_three, 20) << "round the common face and the half discs";
}

/// A cube in two halves with a cubic void within, in which a ball floats, looking inwards.
TopoDS_Shape halves_round_a_ball() {
  const TopoDS_Shape cube = BRepPrimAPI_MakeBox(gp_Pnt(-1, -1, -1), gp_Pnt(1, 1, 1)).Shape();
  const TopoDS_Shape hole = BRepPrimAPI_MakeBox(gp_Pnt(-.5, -.5, -.5), gp_Pnt(.5, .5, .5)).Shape();
  const TopoDS_Shape lower = BRepPrimAPI_MakeBox(gp_Pnt(-2, -2, -2), gp_Pnt(2, 2, 0)).Shape();
  const TopoDS_Shape hollow = BRepAlgoAPI_Cut(cube, hole).Shape();
  BRep_Builder builder;
  TopoDS_Compound bodies;
  builder.MakeCompound(bodies);
  builder.Add(bodies, BRepAlgoAPI_Common(hollow, lower).Shape());
  builder.Add(bodies, BRepAlgoAPI_Cut(hollow, lower).Shape());
  builder.Add(bodies, BRepPrimAPI_MakeSphere(0.3).Shape().Reversed());
  return bodies;
}

TEST_F(OccModels, TellWhichBodyAPointIsIn) {
  const auto geometry = load_model(brep(halves_round_a_ball()));
  ASSERT_EQ(geometry->num_bodies(), 3u);
  const Model model(geometry, 10);
  EXPECT_EQ(model.bodies_at(std::vector<Point>{{0, 0, -7}, {0, 0, 7}, {1, 0, 0}, {4, 4, 4}, {20, 0, 0}}),
            (std::vector<std::uint32_t>{0, 1, 2, kNoEntity, kNoEntity}));
}

TEST_F(OccModels, OfSeveralBodiesKeepTheVoidsBetweenThem) {
  const std::string path = step(halves_round_a_ball(), "MM");
  const auto geometry = load_model(path);
  const Model model(geometry);
  const ClosedSurface surface = close_surface(tessellate_model(path, *geometry, with_details(model)), {1e-9});
  GridOptions options;
  const InitialGrid without = make_initial_grid(surface, options);
  EXPECT_EQ(without.voids, 1u) << "the ball counts as a hole, or the void as a material";
  options.bodies_at = [&](auto points) { return model.bodies_at(points); };
  const InitialGrid grid = make_initial_grid(surface, options);
  EXPECT_EQ(grid.regions, 3u);
  EXPECT_EQ(grid.voids, 1u);
  std::map<std::int32_t, double> volumes;
  for (std::size_t t = 0; t < grid.mesh.tets.size(); ++t) {
    const auto& v = grid.mesh.tets[t];
    const auto& p = grid.mesh.points;
    volumes[grid.mesh.tet_refs[t]] += six_volume(p[v[0]], p[v[1]], p[v[2]], p[v[3]]) / 6;
  }
  ASSERT_EQ(volumes.size(), 3u);
  EXPECT_NEAR(volumes[1], 3.5, 1e-9);
  EXPECT_NEAR(volumes[2], 3.5, 1e-9);
  EXPECT_NEAR(volumes[3], 4.0 / 3 * std::numbers::pi * 0.027, 0.01);
  EXPECT_TRUE(check_mesh(grid.mesh).ok());
}

TEST_F(OccModels, WithAFaceBesideTheirBodiesAreRefusedNamingIt) {
  BRep_Builder builder;
  TopoDS_Compound both;
  builder.MakeCompound(both);
  builder.Add(both, BRepPrimAPI_MakeBox(1, 1, 1).Shape());
  builder.Add(both, BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(3, 0, 0), gp_Dir(0, 0, 1)), 0, 1, 0, 1).Face());
  const std::string path = brep(both);
  const auto geometry = load_model(path);
  try {
    tessellate_model(path, *geometry, {0.01, 20});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("face 7"), HasSubstr("belongs to no body")));
  }
}

TEST_F(OccModels, ThatAreTinyAreTessellatedToo) {
  const std::string path = brep(BRepPrimAPI_MakeCylinder(2e-6, 5e-6).Shape());
  const auto geometry = load_model(path);
  expect_closed(tessellate_model(path, *geometry, {1e-3 * Model(geometry).size(), 20}), 2);
}

/// The part of a cone between two planes through its axis: a tip where two straight edges end.
TopoDS_Shape slice_of_a_cone(double angle) { return BRepPrimAPI_MakeCone(0.5, 0, 1, angle).Shape(); }

TEST_F(OccModels, HaveTrianglesThatLieOnTheirFacesAtPolesToo) {
  const std::map<std::string, TopoDS_Shape> bodies = {
      {"quarter of a cone", slice_of_a_cone(1.5707)},
      {"half a cone", slice_of_a_cone(3.14)},
      {"cone", BRepPrimAPI_MakeCone(1, 0, 2).Shape()},
      {"sphere", BRepPrimAPI_MakeSphere(2).Shape()},
      {"slice of a sphere", BRepPrimAPI_MakeSphere(2, 1.0).Shape()}};
  for (const auto& [name, body] : bodies)
    for (const double sagitta : {0.003, 0.03}) {
      SCOPED_TRACE(name + " " + std::to_string(sagitta));
      const std::string path = brep(body);
      const auto geometry = load_model(path);
      const MeshData mesh = tessellate_model(path, *geometry, {sagitta, 20});
      expect_closed(mesh, 2);
      const Model model(geometry);
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto f = static_cast<std::uint32_t>(mesh.triangle_refs[i] - 1);
        const auto& t = mesh.triangles[i];
        const Point &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        const Vec n = cross(b - a, c - a);
        ASSERT_GT(norm(n), 1e-9);
        const Vec normal = model.closest_within(f, (1.0 / 3) * (a + b + c)).normal;
        const Vec up = (model.face(f).reversed ? -1.0 : 1.0) * normal;
        EXPECT_GT(dot(n, up) / norm(n), 0.5) << "triangle " << i << " of face " << f + 1;
      }
    }
}

TEST_F(OccModels, ThatAreOpenAreTessellatedWithAnErrorThatNamesTheEdge) {
  TopoDS_Shell shell;
  BRep_Builder builder;
  builder.MakeShell(shell);
  int faces = 0;
  for (TopExp_Explorer at(BRepPrimAPI_MakeBox(1, 1, 1).Shape(), TopAbs_FACE); at.More(); at.Next())
    if (++faces != 3) builder.Add(shell, at.Current());
  const std::string path = brep(shell);
  try {
    tessellate_model(path, *load_model(path), {0.01, 20});
    FAIL() << "an open shell was tessellated";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("edge "));
    EXPECT_THAT(error.what(), HasSubstr("open"));
  }
}

/// All that refine's meshes record, evaluated, gives back the vertices: to 1e-8 of the model's size, and
/// where a file's vertices are themselves off the model (cube-sphere's by 4e-6 of it) to five times that
/// distance.
TEST_F(OccModels, OfCasesGiveBackTheRecordedVertices) {
  const fs::path cases = fs::path(WEFT_CASES) / "cad";
  if (!fs::exists(cases)) GTEST_SKIP() << "there is no " << cases;
  const std::map<std::string, std::string> pairs = {
      {"cube-sphere/cube-sphere.meshb", "cube-sphere/cube-sphere.egads"},
      {"hemisphere-cylinder/hsc01.meshb", "hemisphere-cylinder/hemisph-cyl.egads"},
      {"revolve-cylinder/cylinder01.meshb", "revolve-cylinder/cylinder.egads"},
      {"revolve-pencil/pencil.meshb", "revolve-pencil/pencil.egads"},
      {"../ugawg/cone-cone.meshb", "cone-cone/cone-cone.egads"},
      {"../ugawg/cube-cylinder.meshb", "cube-cylinder.egads"}};
  for (const auto& [mesh_name, model_name] : pairs) {
    SCOPED_TRACE(mesh_name);
    const MeshData mesh = read_gmf_mesh(cases / mesh_name);
    const Model model(load_model((cases / model_name).string()));
    double nodes = 0, edges = 0, faces = 0;
    const auto excess = [](double error, double off) { return std::max(0.0, error - 5 * off); };
    for (const auto& r : mesh.association.nodes)
      nodes = std::max(nodes, norm(model.node(static_cast<std::uint32_t>(r.id - 1)) - mesh.points[r.vertex]));
    for (const auto& r : mesh.association.edges) {
      const auto e = static_cast<std::uint32_t>(r.id - 1);
      const Point x = model.edge(e).degenerate ? model.node(model.edge(e).nodes[0]) : model.curve(e, r.t).x;
      const double off = model.closest_on_edge(e, mesh.points[r.vertex]).distance;
      edges = std::max(edges, excess(norm(x - mesh.points[r.vertex]), off));
    }
    for (const auto& r : mesh.association.faces)
      faces = std::max(
          faces,
          excess(
              norm(model.surface(static_cast<std::uint32_t>(r.id - 1), {r.u, r.v}).x - mesh.points[r.vertex]),
              model.closest_on_face(static_cast<std::uint32_t>(r.id - 1), mesh.points[r.vertex]).distance));
    for (const double largest : {nodes, edges, faces}) EXPECT_LE(largest, 1e-8 * model.size());
    EXPECT_GT(mesh.association.faces.size(), 0u);
  }
}

}  // namespace
}  // namespace weft::meshing::occ_model_test
