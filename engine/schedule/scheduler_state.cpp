// What a rank does just now: the lines that Runtime::request_state() shows.
#include <algorithm>
#include <iomanip>
#include <map>

#include "engine/base/text.h"
#include "engine/schedule/scheduler.h"

namespace weft::engine {
namespace {

std::string seconds_text(double seconds) { return text(std::fixed, std::setprecision(1), seconds, " s"); }

}  // namespace

std::string Scheduler::name_and_place(ObjectId id) const {
  std::string name = options_.name_of ? options_.name_of(id) : text("object ", id);
  if (find(id) != nullptr) return name;
  return text(name, " (rank ", directory_.best_guess(id).rank.value, ")");
}

std::string Scheduler::load_line() const {
  std::map<Cell::State, std::size_t> in;
  for (const auto& [id, cell] : cells_) ++in[cell->state];
  return text("load: ", busy_, " of ", options_.threads, " workers busy, ", seconds_text(queued_seconds_),
              " of work predicted, ", handled_, " handled, ", sent_, " sent, ", received_, " received; ",
              cells_.size(), " objects: ", in[Cell::State::running], " running, ", in[Cell::State::ready],
              " ready, ", in[Cell::State::leaving], " leaving, ", in[Cell::State::idle], " without work");
}

std::string Scheduler::state_of(const Cell& cell) const {
  std::string line = text(name_and_place(cell.id), ": ");
  if (cell.state == Cell::State::running) {  // a worker has the object: nobody else may look into it
    const MethodInfo* method = registry_.find_method(cell.runs);
    const double seconds = 1e-9 * static_cast<double>(now() - cell.runs_since);
    return line + text("runs ", method ? method->name : "an unknown handler", " for ", seconds_text(seconds));
  }
  ObjectState state;
  if (cell.packed) state.what = "moved here";
  if (cell.object != nullptr && cell.type->describe != nullptr) state = cell.type->describe(cell.object);
  for (const EventWait& wait : cell.events.waits()) {
    const MethodInfo* method = registry_.find_method(wait.key.method);
    state.waits.push_back({method ? method->name : "an unknown event", wait});
  }
  if (!state.what.empty()) line += state.what + ", ";
  if (!cell.mailbox.empty()) {
    line += text(cell.mailbox.size(), " messages to handle");
  } else {
    line += state.waits.empty() ? "waits for nothing" : "no message to handle";
  }
  for (const NamedWait& named : state.waits) {
    if (!named.wait.declared) continue;  // values have come early: the object does not wait for it
    line += text("; waits in ", named.event, ", round ", named.wait.key.round, ", for");
    const char* between = " ";
    for (const ObjectId id : named.wait.missing) line += std::exchange(between, ", ") + name_and_place(id);
  }
  return line;
}

std::vector<std::string> Scheduler::state() const {
  const Lock lock(mutex_);
  std::vector<const Cell*> cells;
  for (const auto& [id, cell] : cells_) cells.push_back(cell.get());
  std::sort(cells.begin(), cells.end(), [](const Cell* a, const Cell* b) { return a->id < b->id; });
  std::vector<std::string> lines{load_line()};
  for (const Cell* cell : cells) lines.push_back(state_of(*cell));
  for (const auto& [id, tasks] : parked_)
    lines.push_back(text(tasks.size(), " messages wait for ", name_and_place(id), " to come"));
  return lines;
}

}  // namespace weft::engine
