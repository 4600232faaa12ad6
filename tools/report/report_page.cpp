#include "tools/report/report_page.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/report/assets.h"

namespace weft::report {
namespace {

/// JSON that an HTML page may contain: nothing in it ends the script or begins a comment.
std::string in_script(const nlohmann::ordered_json& json) {
  const std::string plain = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string text;
  text.reserve(plain.size());
  for (const char c : plain) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string script(std::string_view text) { return "<script>\n" + std::string(text) + "\n</script>\n"; }

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

}  // namespace

std::string report_page(const nlohmann::ordered_json& profile) {
  if (!profile.is_object() || profile.value("schema", "") != "weft-profile-1")
    throw std::invalid_argument("no weft-profile-1 document");
  std::string scripts = script(asset("chart.min.js"));
  if (!profile.at("mesh").is_null())
    scripts += script(asset("three.min.js")) + script(asset("OrbitControls.js"));
  for (const char* name : {"base.js", "summary.js", "times.js", "timeline.js", "communication.js",
                           "quality.js", "convergence.js", "graph.js", "mesh.js", "details.js", "main.js"})
    scripts += script(asset(name));
  return filled_in("report.html", in_script(profile), scripts);
}

std::string comparison_page(const nlohmann::ordered_json& comparison) {
  const std::string scripts = script(asset("base.js")) + script(asset("comparison.js"));
  return filled_in("comparison.html", in_script(comparison), scripts);
}

}  // namespace weft::report
