// Reads the model, scaled as asked.
#include "tools/library/jobs/sources/model_source.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "meshing/cad/load_model.h"

namespace weft::tools {

std::shared_ptr<const meshing::Model> model_of(const GeometryOptions& options, const meshing::MeshData& mesh,
                                               const std::string& mesh_name) {
  if (options.model.empty()) return nullptr;
  return std::make_shared<const meshing::Model>(options.model == "carried"
                                                    ? meshing::load_carried_model(mesh.association, mesh_name)
                                                    : meshing::load_model(options.model),
                                                options.model_scale);
}

namespace {

/// But for what fills up words at the end.
bool is_content_of(const std::string& file, const std::vector<std::uint8_t>& bytes) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> content((std::istreambuf_iterator<char>(in)), {});
  constexpr std::size_t kWord = 4;
  return bytes.size() >= content.size() && bytes.size() - content.size() < kWord &&
         std::equal(content.begin(), content.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

}  // namespace

std::string leave_out_other_model(const GeometryOptions& options, meshing::Association& carried) {
  if (options.model.empty() || options.model == "carried" || carried.model.empty()) return {};
  if (is_content_of(options.model, carried.model)) return {};
  carried.model.clear();
  return "the model that the mesh carries is left out of the result, whose records are of " + options.model;
}

std::vector<std::string> model_warnings(const meshing::Model* model) {
  std::vector<std::string> all;
  if (!model) return all;
  for (const std::string& warning : model->geometry().warnings())
    all.push_back(model->geometry().name() + ": " + warning);
  return all;
}

}  // namespace weft::tools
