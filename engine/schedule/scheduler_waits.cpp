// Who waits for whom: the lines that a stalled run shows.
#include <algorithm>

#include "engine/base/text.h"
#include "engine/schedule/scheduler.h"

namespace weft::engine {

std::string Scheduler::where(ObjectId id) const {
  if (find(id) != nullptr) return text(id, " (rank ", options_.rank.value, ")");
  return text(id, " (last known on rank ", directory_.best_guess(id).rank.value, ")");
}

void Scheduler::describe_waits(const Cell& cell, std::vector<std::string>& lines) const {
  const std::string subject =
      text("object ", cell.id, " (", cell.type->name, ", rank ", options_.rank.value, ") ");
  for (const EventWait& wait : cell.events.waits()) {
    const MethodInfo* method = registry_.find_method(wait.key.method);
    const std::string event = text(method ? method->name : "an unknown event", " in round ", wait.key.round);
    std::string line = subject;
    if (!wait.declared) {
      line += text("never expects ", event, ", signalled by");
      for (const ObjectId id : wait.arrived) line += ' ' + text(id);
    } else {
      line += text("waits in ", event, " for");
      for (const ObjectId id : wait.missing) line += ' ' + where(id);
      if (!wait.arrived.empty()) line += "; arrived:";
      for (const ObjectId id : wait.arrived) line += ' ' + text(id);
    }
    lines.push_back(line);
  }
  for (const auto& [sender, inbound] : cell.inbound) {
    if (inbound.held.empty()) continue;
    lines.push_back(text(subject, "lacks message ", inbound.next, " of object ", where(sender), " and holds ",
                         inbound.held.size(), " later ones"));
  }
}

std::vector<std::string> Scheduler::waits() const {
  const Lock lock(mutex_);
  std::vector<std::string> lines;
  for (const auto& [id, cell] : cells_) describe_waits(*cell, lines);
  for (const auto& [id, tasks] : parked_) {
    lines.push_back(text(tasks.size(), " messages wait on rank ", options_.rank.value, " for object ", id,
                         id.home == options_.rank && id.number > created_ ? ", which was never created"
                                                                          : ", which has not come"));
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace weft::engine
