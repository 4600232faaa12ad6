// What the part of weft that knows OpenCASCADE offers to the rest, which loads it when a model is asked for.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "meshing/geometry/model/geometry_model.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct CadTessellation {
  double sagitta = 0;                      ///< largest distance of an edge from the model
  double angle_degrees = 20;               ///< that the normal turns along an edge
  std::vector<double> face_sagittas = {};  ///< of each face, where it is less than that of all; or empty
};

class CadReader {
 public:
  virtual ~CadReader() = default;
  /// Reads STEP, IGES or BREP by the file's extension. Throws InputError naming file, entity and reason.
  virtual std::shared_ptr<const GeometryModel> read(const std::string& path) const = 0;
  /// Reads like read(), for another process, and leaves in the file `kept` what it has read, bit by bit;
  /// where that cannot be written, nothing.
  virtual void keep(const std::string& path, const std::string& kept) const = 0;
  /// What read(path) would give, in little time; null where nothing was kept.
  virtual std::shared_ptr<const GeometryModel> read_kept(const std::string& path,
                                                         const std::string& kept) const = 0;
  /// Triangles on a model that read() has given: conforming across edges, references are the ids of faces and
  /// edges, corners the nodes; associated with the model. Throws InputError naming the entity where they
  /// would not be closed.
  virtual MeshData tessellate(const GeometryModel& model, const CadTessellation& options) const = 0;
};

/// The part that offers it (see load_part.h).
inline constexpr const char* kCadEntryName = "weft_cad_reader";
inline constexpr int kCadInterface = 5;

}  // namespace weft::meshing
