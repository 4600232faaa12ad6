// Reads the model, scaled as asked.
#include "tools/library/jobs/sources/model_source.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "meshing/cad/load_model.h"

namespace weft::tools {
namespace {

/// But for what fills up words at the end.
bool is_carried(const std::vector<std::uint8_t>& content, const std::vector<std::uint8_t>& carried) {
  constexpr std::size_t kWord = 4;
  return carried.size() >= content.size() && carried.size() - content.size() < kWord &&
         std::equal(content.begin(), content.end(), carried.begin());
}

std::vector<std::uint8_t> content_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::shared_ptr<const meshing::Model> model_of(const GeometryOptions& options, const meshing::MeshData& mesh,
                                               const std::string& mesh_name) {
  if (options.model.empty()) return nullptr;
  return std::make_shared<const meshing::Model>(options.model == "carried"
                                                    ? meshing::load_carried_model(mesh.association, mesh_name)
                                                    : meshing::load_model(options.model),
                                                options.model_scale);
}

std::string carry_model(const GeometryOptions& options, meshing::Association& carried) {
  if (options.model.empty() || options.model == "carried" || carried.model.empty()) return {};
  std::vector<std::uint8_t> content = content_of(options.model);
  if (is_carried(content, carried.model)) return {};
  if (std::filesystem::path(options.model).extension() == ".egads") {
    carried.model = std::move(content);
    return {};
  }
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
