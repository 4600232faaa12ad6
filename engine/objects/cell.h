// A mobile object with all that belongs to it, at rest and on its way.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "engine/objects/event.h"
#include "engine/objects/experience.h"
#include "engine/objects/message.h"
#include "engine/objects/registry.h"
#include "engine/trace/trace.h"

namespace weft::engine {

/// A mobile object where it lives: the object, or what it was packed into (it is unpacked when it is first
/// needed, so an object that moves on costs nothing here), and all that travels with it.
struct Cell {
  enum class State : std::uint8_t {
    idle,     ///< no message waits
    ready,    ///< messages wait, in the scheduler's queue
    running,  ///< a worker has it
    leaving,  ///< it moves before its next message is handled
  };
  /// What has come from one sender.
  struct Inbound {
    std::uint64_t next = 0;              ///< sequence number of the next message to accept
    std::map<std::uint64_t, Task> held;  ///< came before their turn

    template <class Archive>
    void serialize(Archive& archive) {
      archive(next, held);
    }
  };

  ObjectId id;
  const TypeInfo* type = nullptr;  ///< null: the rank's root
  void* object = nullptr;
  std::optional<Payload> packed;
  std::uint32_t age = 0;    ///< number of moves
  std::uint64_t epoch = 0;  ///< of the last snapshot that has its copy
  State state = State::idle;
  Rank leaves_for;  ///< set: moves there as soon as no worker has it
  bool destroyed = false;
  bool waits = false;    ///< for an event, or for the messages before those held
  std::size_t held = 0;  ///< messages that came before their turn
  double queued_seconds = 0;
  Experiences costs;
  std::uint32_t runs = 0;    ///< while running: hash of the method's name
  TimePoint runs_since = 0;  ///< while running
  std::uint32_t lane = 0;    ///< while running: the worker's, by Trace::lanes()
  std::deque<Task> mailbox;
  std::unordered_map<ObjectId, Inbound> inbound;
  std::unordered_map<ObjectId, std::uint64_t> outbound;  ///< sequence number of the next message to each
  EventTable events;

  Cell() = default;
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;
  ~Cell() {
    if (object != nullptr) type->destroy(object);
  }
};

/// What a cell is while it travels.
struct PackedCell {
  ObjectId id;
  std::uint32_t type = 0;
  std::uint32_t age = 0;
  std::uint64_t epoch = 0;
  Payload object;
  std::vector<Task> mailbox;
  std::unordered_map<ObjectId, Cell::Inbound> inbound;
  std::unordered_map<ObjectId, std::uint64_t> outbound;
  EventTable events;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(id, type, age, epoch, object, mailbox, inbound, outbound, events);
  }
};

}  // namespace weft::engine
