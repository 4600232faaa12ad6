// Reads STEP, IGES and BREP files, keeps their units, mends and checks what it gets, and tessellates.
#include <BOPAlgo_Builder.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Reader.hxx>
#include <ShapeFix_Shape.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <UnitsMethods.hxx>
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/cad/cad_reader.h"
#include "meshing/cad/occ_model.h"
#include "meshing/cad/occ_tessellate.h"

namespace weft::meshing {
namespace {

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// A unit of length as files call it, in millimetres, and as people do.
struct Unit {
  const char* file;
  double millimetres;
  const char* name;
};
constexpr std::array<Unit, 19> kUnits = {{
    {"millimetre", 1, "millimetre"},
    {"mm", 1, "millimetre"},
    {"metre", 1000, "metre"},
    {"meter", 1000, "metre"},
    {"m", 1000, "metre"},
    {"centimetre", 10, "centimetre"},
    {"cm", 10, "centimetre"},
    {"kilometre", 1e6, "kilometre"},
    {"km", 1e6, "kilometre"},
    {"micrometre", 1e-3, "micrometre"},
    {"um", 1e-3, "micrometre"},
    {"inch", 25.4, "inch"},
    {"in", 25.4, "inch"},
    {"foot", 304.8, "foot"},
    {"ft", 304.8, "foot"},
    {"mile", 1609344, "mile"},
    {"mi", 1609344, "mile"},
    {"millimeter", 1, "millimetre"},
    {"mil", 0.0254, "mil"},
}};

const Unit* find_unit(const std::string& name) {
  const auto found = std::ranges::find_if(kUnits, [&](const Unit& u) { return lower(name) == u.file; });
  return found == kUnits.end() ? nullptr : &*found;
}

const Unit& unit_called(const std::string& name, std::vector<std::string>& warnings) {
  const Unit* unit = find_unit(name);
  if (!unit) {
    warnings.push_back("unit of length '" + name + "' is not known: lengths are in millimetres");
    unit = &kUnits[0];
  }
  return *unit;
}

struct Read {
  TopoDS_Shape shape;
  std::string unit;
  double millimetres = 1;  ///< of the unit
  std::vector<std::string> warnings;
};

Read read_step(const std::string& path) {
  Read result;
  STEPControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
    throw InputError(path, "", "is no STEP file, or is damaged or truncated");
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.FileUnits(lengths, angles, solid_angles);
  const Unit& unit =
      unit_called(lengths.IsEmpty() ? "millimetre" : lengths.First().ToCString(), result.warnings);
  result.unit = unit.name;
  result.millimetres = unit.millimetres;
  if (lengths.Length() > 1)
    result.warnings.push_back("parts have different units of length; all are converted to " + result.unit);
  const int roots = reader.NbRootsForTransfer(), transferred = reader.TransferRoots();
  if (transferred < roots)
    result.warnings.push_back(std::to_string(roots - transferred) + " of " + std::to_string(roots) +
                              " parts cannot be read");
  if (reader.NbShapes() == 0) throw InputError(path, "", "holds no shape, or is damaged or truncated");
  result.shape = reader.OneShape();
  return result;
}

Read read_iges(const std::string& path) {
  Read result;
  IGESControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
    throw InputError(path, "", "is no IGES file, or is damaged or truncated");
  const Handle(IGESData_IGESModel) model = Handle(IGESData_IGESModel)::DownCast(reader.Model());
  result.unit = "millimetre";
  if (!model.IsNull() && !model->GlobalSection().UnitName().IsNull()) {
    const Unit& unit = unit_called(model->GlobalSection().UnitName()->ToCString(), result.warnings);
    result.unit = unit.name;
    result.millimetres = unit.millimetres;
  }
  reader.TransferRoots();
  if (reader.NbShapes() == 0) throw InputError(path, "", "holds no shape, or is damaged or truncated");
  result.shape = reader.OneShape();
  return result;
}

/// Whether the shapes that a BREP file announces are all there: of a truncated one OpenCASCADE's reader makes
/// damaged shapes, or reads for ever.
bool is_whole_brep(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string word;
  while (file >> word && word != "TShapes") continue;
  long announced = 0;
  if (!(file >> announced) || announced < 1) return false;
  // The list of the parts of each shape ends with a star, and after all comes the one that is meant.
  for (long ended = 0; ended < announced;) {
    if (!(file >> word)) return false;
    ended += word == "*";
  }
  return static_cast<bool>(file >> word);
}

Read read_brep(const std::string& path) {
  Read result;
  if (!is_whole_brep(path)) throw InputError(path, "", "is no BREP file, or is damaged or truncated");
  BRep_Builder builder;
  if (!BRepTools::Read(result.shape, path.c_str(), builder) || result.shape.IsNull())
    throw InputError(path, "", "is no BREP file, or is damaged or truncated");
  return result;
}

bool has(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) { return TopExp_Explorer(shape, kind).More(); }

TopTools_IndexedMapOfShape all_of(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape all;
  TopExp::MapShapes(shape, kind, all);
  return all;
}

/// Loose faces, as IGES has them, are sewn together.
void sew(Read& read) {
  if (has(read.shape, TopAbs_SHELL)) return;
  BRepBuilderAPI_Sewing sewing(1e-6);
  sewing.Add(read.shape);
  sewing.Perform();
  if (sewing.SewedShape().IsNull()) return;
  read.shape = sewing.SewedShape();
  read.warnings.push_back("loose faces have been sewn together");
}

/// OpenCASCADE converts all lengths to millimetres; the file's own numbers are wanted.
void keep_numbers(Read& read) {
  if (read.millimetres == 1) return;
  gp_Trsf scale;
  scale.SetScale(gp_Pnt(), 1 / read.millimetres);
  read.shape = BRepBuilderAPI_Transform(read.shape, scale, Standard_True).Shape();
}

/// Whether anything of the shape is something else in what has been built of it.
bool changes(BOPAlgo_Builder& builder, const TopoDS_Shape& shape) {
  for (const TopAbs_ShapeEnum kind : {TopAbs_FACE, TopAbs_EDGE, TopAbs_VERTEX}) {
    const TopTools_IndexedMapOfShape all = all_of(shape, kind);
    for (int i = 1; i <= all.Extent(); ++i)
      if (!builder.Modified(all(i)).IsEmpty()) return true;
  }
  return false;
}

/// In STEP each body has faces of its own, also where bodies touch: there they would be divided differently,
/// and a mesh of both would not conform. What they have in common becomes common.
void join_bodies(Read& read) {
  if (all_of(read.shape, TopAbs_SOLID).Extent() < 2) return;
  BOPAlgo_Builder builder;
  for (const auto& [kind, within] :
       {std::pair(TopAbs_SOLID, TopAbs_SHAPE), std::pair(TopAbs_SHELL, TopAbs_SOLID),
        std::pair(TopAbs_FACE, TopAbs_SHELL)})
    for (TopExp_Explorer at(read.shape, kind, within); at.More(); at.Next())
      builder.AddArgument(at.Current());
  builder.Perform();
  if (builder.HasErrors()) {
    read.warnings.push_back("it cannot be found out where its bodies touch");
    return;
  }
  if (!changes(builder, read.shape)) return;
  read.shape = builder.Shape();
  read.warnings.push_back(
      "bodies touch: faces that they have in common are common now, and ids are other than in the file");
}

void mend(Read& read) {
  ShapeFix_Shape fix(read.shape);
  fix.Perform();
  read.shape = fix.Shape();
}

/// Faces that OpenCASCADE's own check refuses, by id.
void check(Read& read) {
  const BRepCheck_Analyzer analyzer(read.shape);
  if (analyzer.IsValid()) return;
  const TopTools_IndexedMapOfShape faces = all_of(read.shape, TopAbs_FACE);
  std::string list;
  int bad = 0;
  for (int i = 1; i <= faces.Extent(); ++i)
    if (!analyzer.IsValid(faces(i)) && ++bad <= 10) list += (list.empty() ? "" : ", ") + std::to_string(i);
  read.warnings.push_back(bad == 0 ? std::string("the topology of the model is not valid")
                                   : "faces that are not valid in themselves: " + list +
                                         (bad > 10 ? " and " + std::to_string(bad - 10) + " more" : ""));
}

void refuse_empty(const std::string& path, const TopoDS_Shape& shape) {
  if (!has(shape, TopAbs_FACE)) throw InputError(path, "", "holds no face");
}

/// Readers keep their parameters in global variables, and print.
std::mutex& readers() {
  static std::mutex mutex;
  return mutex;
}

Read read_by_extension(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  const bool exact = extension == ".brep" || extension == ".brp" || extension == ".egads";
  Read read = exact ? read_brep(path)
                    : (extension == ".step" || extension == ".stp" ? read_step(path) : read_iges(path));
  refuse_empty(path, read.shape);
  // A BREP file is taken as it is: ids and parameters are those that other programs have recorded.
  if (!exact) {
    sew(read);
    mend(read);
    join_bodies(read);
    keep_numbers(read);
  }
  BRepLib::BuildCurves3d(read.shape);
  check(read);
  return read;
}

class OccReader : public CadReader {
 public:
  std::shared_ptr<const GeometryModel> read(const std::string& path) const override {
    const std::scoped_lock lock(readers());
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
    try {
      // Whoever else uses OpenCASCADE in this process may have set another unit.
      UnitsMethods::SetCasCadeLengthUnit(1.0);
      Read read = read_by_extension(path);
      return std::make_shared<OccModel>(read.shape, path, read.unit, std::move(read.warnings));
    } catch (const Standard_Failure& failure) {
      throw InputError(path, "", std::string("OpenCASCADE cannot read it: ") + failure.GetMessageString());
    }
  }

  MeshData tessellate(const GeometryModel& model, const CadTessellation& options) const override {
    const std::scoped_lock lock(readers());
    try {
      return tessellate_occ(dynamic_cast<const OccModel&>(model), options);
    } catch (const Standard_Failure& failure) {
      throw InputError(model.name(), "",
                       std::string("OpenCASCADE cannot tessellate it: ") + failure.GetMessageString());
    }
  }
};

}  // namespace
}  // namespace weft::meshing

extern "C" __attribute__((visibility("default"))) const weft::meshing::CadReader* weft_cad_reader(
    int interface) {
  static const weft::meshing::OccReader reader;
  return interface == weft::meshing::kCadInterface ? &reader : nullptr;
}
