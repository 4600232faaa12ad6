#include "tools/report/report_page.h"

#include <initializer_list>
#include <stdexcept>

#include "engine/json/json.h"
#include "tools/report/assets.h"
#include "tools/report/encode/base64.h"
#include "tools/report/encode/gzip.h"

namespace weft::report {
namespace {

/// What the page's readData() turns back: the columns of a large run shrink to a quarter. Base64 has nothing
/// that could end the script that it stands in.
std::string packed(const nlohmann::ordered_json& json) {
  const std::string plain = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return base64_of(gzip(plain));
}

std::string script(std::string_view text) { return "<script>\n" + std::string(text) + "\n</script>\n"; }

/// One module: its first part waits for the data, so that the others have them.
std::string module_of(std::initializer_list<const char*> names) {
  std::string text;
  for (const char* name : names) text += asset(name);
  return "<script type=\"module\">\n" + text + "\n</script>\n";
}

/// `template_name`: with the words {{style}}, {{data}} and {{scripts}} where these go.
std::string filled_in(std::string_view template_name, const std::string& data, const std::string& scripts) {
  std::string page(asset(template_name));
  const auto put = [&page](std::string_view word, std::string_view text) {
    page.replace(page.find(word), word.size(), text);
  };
  put("{{style}}", asset("style.css"));
  put("{{scripts}}", scripts);
  put("{{data}}", data);
  return page;
}

/// With what older versions did not write, empty. Throws for what all of them wrote.
nlohmann::ordered_json completed(nlohmann::ordered_json profile) {
  for (const char* added : {"left", "published_curves"})
    if (!profile.contains(added)) profile[added] = nlohmann::ordered_json::array();
  if (!profile.contains("simulation")) profile["simulation"] = nullptr;
  for (const char* member : {"case", "report", "operations", "total", "ranks", "engine", "messages",
                             "waiting", "critical_path", "convergence", "graph", "uses_left_out",
                             "operation_of_node", "timeline", "memory", "hardware", "published", "mesh"})
    if (!profile.contains(member))
      throw std::invalid_argument(std::string("has no \"") + member +
                                  "\": it is damaged, or of another version of weft");
  return profile;
}

}  // namespace

std::string report_page(const nlohmann::ordered_json& any_profile) {
  if (engine::schema_of(any_profile) != "weft-profile-1")
    throw std::invalid_argument("no weft-profile-1 document");
  const nlohmann::ordered_json profile = completed(any_profile);
  std::string scripts = script(asset("chart.min.js"));
  if (!profile.at("mesh").is_null())
    scripts += script(asset("three.min.js")) + script(asset("OrbitControls.js"));
  scripts += module_of({"base.js", "summary.js", "times.js", "timeline.js", "communication.js", "quality.js",
                        "convergence.js", "graph.js", "mesh.js", "details.js", "main.js"});
  return filled_in("report.html", packed(profile), scripts);
}

std::string comparison_page(const nlohmann::ordered_json& comparison) {
  return filled_in("comparison.html", packed(comparison), module_of({"base.js", "comparison.js"}));
}

}  // namespace weft::report
