// Reads STEP, IGES and BREP files, keeps their units, mends and checks what it gets, and tessellates.
#include <BOPAlgo_Builder.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <Bnd_Box.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_InterfaceModel.hxx>
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
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/cad/cad_reader.h"
#include "meshing/cad/check_model.h"
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
  double gaps = 0;         ///< that the file's program takes for none; millimetres
  std::vector<std::string> warnings;
};

/// The first of them, and how many more there are.
std::string listed(const std::vector<std::string>& all, std::size_t most = 10, const char* between = ", ") {
  std::string text;
  for (std::size_t i = 0; i < std::min(all.size(), most); ++i) text += (i > 0 ? between : "") + all[i];
  return all.size() > most ? text + " and " + std::to_string(all.size() - most) + " more" : text;
}

/// What the reader has found wrong with entities of a STEP file, by their ids there.
void list_failures(Interface_CheckIterator checks, const Handle(Interface_InterfaceModel) & model,
                   std::vector<std::string>& failures) {
  for (checks.Start(); checks.More(); checks.Next()) {
    const Handle(Interface_Check) check = checks.Value();
    std::string why;
    if (check->NbFails() > 0) why = check->CFail(1);
    for (int i = 1; why.empty() && i <= check->NbWarnings(); ++i)
      if (std::string_view(check->CWarning(i)).find("not translated") != std::string_view::npos)
        why = check->CWarning(i);
    if (why.empty()) continue;
    const int number = checks.Number();
    const std::string entity = number >= 1 && number <= model->NbEntities()
                                   ? model->StringLabel(model->Value(number))->ToCString()
                                   : "the file";
    failures.push_back(entity + " (" + why.substr(why.find_first_not_of(' ')) + ")");
  }
}

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
  std::vector<std::string> failures;
  list_failures(reader.WS()->ModelCheckList(Standard_False), reader.Model(), failures);
  const int roots = reader.NbRootsForTransfer(), transferred = reader.TransferRoots();
  if (transferred < roots)
    result.warnings.push_back(std::to_string(roots - transferred) + " of " + std::to_string(roots) +
                              " parts cannot be read");
  list_failures(reader.WS()->TransferReader()->LastCheckList(), reader.Model(), failures);
  if (!failures.empty())
    result.warnings.push_back("entities of the file that are damaged or cannot be read: " + listed(failures));
  if (reader.NbShapes() == 0) throw InputError(path, "", "holds no shape, or is damaged or truncated");
  result.shape = reader.OneShape();
  return result;
}

/// The specification's flags stand for names, which may be missing; without both lengths are in inches.
std::string name_of_unit(const IGESData_GlobalSection& global) {
  constexpr std::array<const char*, 12> kOfFlag = {"INCH", "INCH", "MM",  "",   "FT", "MI",
                                                   "M",    "KM",   "MIL", "UM", "CM", ""};
  const int flag = global.UnitFlag();
  const bool known = flag >= 0 && flag < static_cast<int>(kOfFlag.size());
  if (known && *kOfFlag[static_cast<std::size_t>(flag)] != 0) return kOfFlag[static_cast<std::size_t>(flag)];
  return global.UnitName().IsNull() ? "INCH" : global.UnitName()->ToCString();
}

Read read_iges(const std::string& path) {
  Read result;
  IGESControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
    throw InputError(path, "", "is no IGES file, or is damaged or truncated");
  const Handle(IGESData_IGESModel) model = Handle(IGESData_IGESModel)::DownCast(reader.Model());
  result.unit = "millimetre";
  if (!model.IsNull()) {
    const IGESData_GlobalSection& global = model->GlobalSection();
    const Unit& unit = unit_called(name_of_unit(global), result.warnings);
    result.unit = unit.name;
    result.millimetres = unit.millimetres;
    result.gaps = global.Resolution() * unit.millimetres;
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

/// How many times each edge borders a face of the body, by its number among `edges`; one within a face has it
/// on both sides.
std::map<int, int> uses_of_edges(const TopoDS_Shape& body, const TopTools_IndexedMapOfShape& edges) {
  std::map<int, int> uses;
  for (TopExp_Explorer edge(body, TopAbs_EDGE); edge.More(); edge.Next())
    if (!BRep_Tool::Degenerated(TopoDS::Edge(edge.Current())))
      uses[edges.FindIndex(edge.Current())] += edge.Current().Orientation() == TopAbs_INTERNAL ? 2 : 1;
  return uses;
}

/// Several shells that may be parts of one.
bool are_loose_shells(const TopoDS_Shape& shape) {
  if (all_of(shape, TopAbs_SHELL).Extent() < 2) return false;
  const auto uses = uses_of_edges(shape, all_of(shape, TopAbs_EDGE));
  return std::ranges::any_of(uses, [](const auto& use) { return use.second == 1; });
}

/// Gaps are what the file's program takes for none, at most a small part of the shape.
double sewing_tolerance(const Read& read) {
  Bnd_Box box;
  BRepBndLib::Add(read.shape, box);
  constexpr double kLeast = 1e-6, kMostOfSize = 1e-4;
  const double most = box.IsVoid() ? kLeast : kMostOfSize * std::sqrt(box.SquareExtent());
  return std::max(kLeast, std::min(read.gaps, most));
}

/// Loose faces, as IGES has them, are sewn together, and loose shells where nothing of the file is damaged:
/// of a solid that has lost a face readers make shells, which are to be refused.
void sew(Read& read) {
  if (has(read.shape, TopAbs_SOLID)) return;
  if (has(read.shape, TopAbs_SHELL) && (!read.warnings.empty() || !are_loose_shells(read.shape))) return;
  BRepBuilderAPI_Sewing sewing(sewing_tolerance(read));
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
  std::vector<std::string> bad;
  for (int i = 1; i <= faces.Extent(); ++i)
    if (!analyzer.IsValid(faces(i))) bad.push_back(std::to_string(i));
  read.warnings.push_back(bad.empty() ? "the topology of the model is not valid"
                                      : "faces that are not valid in themselves: " + listed(bad));
}

/// Edges that bound one face only of a solid's shell; of any, where there is no solid: readers make shells of
/// one that has lost a face. (A loose face beside a solid is none of its body.)
void find_open_edges(Read& read) {
  const TopTools_IndexedMapOfShape edges = all_of(read.shape, TopAbs_EDGE);
  const bool has_solids = has(read.shape, TopAbs_SOLID);
  const TopTools_IndexedMapOfShape bodies = all_of(read.shape, has_solids ? TopAbs_SOLID : TopAbs_SHELL);
  std::vector<std::string> open;
  for (int i = 1; i <= bodies.Extent(); ++i) {
    for (const auto& [index, count] : uses_of_edges(bodies(i), edges))
      if (count == 1) open.push_back(std::to_string(index));
  }
  if (!open.empty()) read.warnings.push_back("the model is open at edge " + listed(open));
}

/// Throws where what has been read is not the body that is meant.
void check(OccModel& model) {
  const ModelDefects defects = defects_of(model);
  if (!defects.fatal.empty()) {
    std::string also;
    for (const std::string& warning : model.warnings()) also += "; " + warning;
    throw InputError(model.name(), "", "the model is damaged: " + listed(defects.fatal, 3, "; ") + also);
  }
  if (!defects.slight.empty()) model.warn(listed(defects.slight, 10, "; "));
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
  find_open_edges(read);
  return read;
}

std::shared_ptr<const GeometryModel> checked_model(Read&& read, const std::string& path) {
  const auto model = std::make_shared<OccModel>(read.shape, path, read.unit, std::move(read.warnings));
  check(*model);
  return model;
}

constexpr const char* kKept = "weft keeps a shape";

/// Unit and warnings a line each, then the shape.
void write_kept(const Read& read, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  out << kKept << '\n' << read.unit << '\n' << read.warnings.size() << '\n';
  for (std::string line : read.warnings) {
    std::ranges::replace(line, '\n', ' ');
    out << line << '\n';
  }
  BinTools::Write(read.shape, out);
  out.close();
  if (!out) std::ofstream(path, std::ios::trunc);
}

std::optional<Read> kept_in(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line != kKept) return std::nullopt;
  Read read;
  std::getline(in, read.unit);
  std::getline(in, line);
  read.warnings.resize(std::stoul(line));
  for (std::string& warning : read.warnings) std::getline(in, warning);
  BinTools::Read(read.shape, in);
  if (read.shape.IsNull()) return std::nullopt;
  return read;
}

/// One at a time, silent, and OpenCASCADE's exceptions as InputError.
template <class Work>
auto guarded(const std::string& path, const Work& work) {
  const std::scoped_lock lock(readers());
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  try {
    // Whoever else uses OpenCASCADE in this process may have set another unit.
    UnitsMethods::SetCasCadeLengthUnit(1.0);
    return work();
  } catch (const Standard_Failure& failure) {
    throw InputError(path, "", std::string("OpenCASCADE cannot read it: ") + failure.GetMessageString());
  }
}

class OccReader : public CadReader {
 public:
  std::shared_ptr<const GeometryModel> read(const std::string& path) const override {
    return guarded(path, [&] { return checked_model(read_by_extension(path), path); });
  }

  void keep(const std::string& path, const std::string& kept) const override {
    guarded(path, [&] {
      Read read = read_by_extension(path);
      checked_model(Read(read), path);
      write_kept(read, kept);
    });
  }

  std::shared_ptr<const GeometryModel> read_kept(const std::string& path,
                                                 const std::string& kept) const override {
    return guarded(path, [&]() -> std::shared_ptr<const GeometryModel> {
      std::optional<Read> read = kept_in(kept);
      return read ? checked_model(std::move(*read), path) : nullptr;
    });
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

extern "C" __attribute__((visibility("default"))) const void* weft_cad_reader(int interface) {
  using namespace weft::meshing;
  static const OccReader reader;
  return interface == kCadInterface ? static_cast<const CadReader*>(&reader) : nullptr;
}
