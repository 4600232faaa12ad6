// Work of a library that damaged data can crash, or that an error leaves in disorder, done where nothing is
// lost.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace weft::meshing {

/// Runs `work` in a copy of this process and waits for its end. Returns its error (an exception's
/// words, too; "" for none), or nothing where it did not live to its end or took longer than
/// `patience` seconds (0: any time). The copy's memory goes with it: only files that `work` writes remain.
/// What it prints goes nowhere; crashes and alarms end it, also where this process outlives them, interrupts
/// do not. Where there can be no other process, `work` is done in this one.
std::optional<std::string> issue_of_child(const std::function<std::string()>& work, unsigned patience);

}  // namespace weft::meshing
