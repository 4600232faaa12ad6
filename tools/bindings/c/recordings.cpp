// Recorded runs: their replays, task graphs and pages.
#include <optional>
#include <string>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"
#include "weft/replay.h"

namespace weft::c {
namespace {

weft_replay_settings default_replay() {
  static const ReplayOptions options;
  weft_replay_settings s{};
  s.size = sizeof s;
  s.ranks = options.ranks;
  s.threads = options.threads;
  s.network = options.network.c_str();
  s.balancer = options.balancer.c_str();
  s.slowdown = options.slowdown;
  s.grow = options.grow;
  s.copies = options.copies;
  s.split = options.split;
  return s;
}

ReplayOptions replay_options_of(const weft_replay_settings* settings) {
  weft_replay_settings s = default_replay();
  if (settings) copy_sized(&s, sizeof s, settings, settings->size, "settings");
  ReplayOptions options;
  options.ranks = s.ranks;
  options.threads = s.threads;
  options.network = require_text(s.network, "network");
  options.balancer = require_text(s.balancer, "balancer");
  options.slowdown = s.slowdown;
  options.grow = s.grow;
  require(s.subdomain_bytes >= 0,
          "subdomain_bytes: " + std::to_string(s.subdomain_bytes) + " is less than 0");
  options.subdomain_bytes = static_cast<std::uint64_t>(s.subdomain_bytes);
  options.processor_times = s.processor_times != 0;
  options.copies = s.copies;
  options.split = s.split;
  options.report = text_or_none(s.report);
  options.account = text_or_none(s.account);
  options.trace = text_or_none(s.trace);
  return options;
}

weft_graph_filter default_filter() {
  weft_graph_filter f{};
  f.size = sizeof f;
  f.round = f.subdomain = -1;
  f.collapse = "none";
  return f;
}

std::optional<std::uint64_t> only(std::int64_t number, const char* argument) {
  if (number == -1) return std::nullopt;
  require(number >= 0, std::string(argument) + ": " + std::to_string(number) + " is less than -1");
  return static_cast<std::uint64_t>(number);
}

GraphFilter filter_of(const weft_graph_filter* filter) {
  weft_graph_filter f = default_filter();
  if (filter) copy_sized(&f, sizeof f, filter, filter->size, "filter");
  GraphFilter known;
  known.round = only(f.round, "round");
  known.subdomain = only(f.subdomain, "subdomain");
  known.collapse = require_text(f.collapse, "collapse");
  known.critical_path = f.critical_path != 0;
  known.plan = f.plan != 0;
  return known;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_replay_settings_default(weft_replay_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_replay(), "settings");
  });
}

weft_status weft_replay(const char* graph, const weft_replay_settings* settings, weft_text** summary,
                        weft_text** json) {
  return guarded([&] {
    const weft::ReplayResult result = weft::replay(require_text(graph, "graph"), replay_options_of(settings));
    NewHandle told = new_text(weft::summary(result)), account = new_text(result.json);
    told.give(summary);
    account.give(json);
  });
}

weft_status weft_graph_filter_default(weft_graph_filter* filter) {
  return guarded([&] {
    require_place(filter, "filter");
    fill_sized(*filter, default_filter(), "filter");
  });
}

weft_status weft_graph_text(const char* path, const char* format, const weft_graph_filter* filter,
                            weft_text** text) {
  return guarded([&] {
    require_place(text, "text");
    give_text(text, weft::graph_text(require_text(path, "path"), require_text(format, "format"),
                                     filter_of(filter)));
  });
}

weft_status weft_report_page(const char* profile, const char* page) {
  return guarded(
      [&] { weft::write_report_page(require_text(profile, "profile"), require_text(page, "page")); });
}

weft_status weft_compare_reports(const char* a, const char* b, const char* page, weft_text** text) {
  return guarded([&] {
    require_place(text, "text");
    give_text(text, weft::compare_reports(require_text(a, "a"), require_text(b, "b"), text_or_none(page)));
  });
}

}  // extern "C"
