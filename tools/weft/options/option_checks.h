// Checks of option values beyond the parser's own, which accept NaN and infinity; defaults that commands
// share.
#pragma once

#include <CLI/CLI.hpp>
#include <iterator>
#include <map>
#include <string>

namespace weft::tools {

/// Any number but NaN and infinity.
CLI::Validator finite_number();
/// A finite number above zero.
CLI::Validator positive_number();
/// A number from 1 up, infinity included.
CLI::Validator number_from_one();
/// A whole number, or the word auto.
CLI::Validator number_or_auto();
/// The name of a mesh file of any format.
CLI::Validator mesh_output_name();
/// The name of a mesh file whose format holds tets.
CLI::Validator volume_output_name();
/// The name of a solution file.
CLI::Validator solution_name();

/// One of the words, of which there are at least two; their values' numbers are no words.
template <class Value>
CLI::Validator one_of(const std::map<std::string, Value>& words) {
  return {[words](std::string& word) -> std::string {
            const auto found = words.find(word);
            if (found == words.end()) {
              std::string known;
              for (auto known_word = words.begin(); known_word != words.end(); ++known_word)
                known += (known.empty()                          ? ""
                          : std::next(known_word) == words.end() ? " and "
                                                                 : ", ") +
                         known_word->first;
              return "'" + word + "' is not one of " + known;
            }
            word = CLI::detail::value_string(found->second);
            return {};
          },
          ""};
}

/// The name of a picture.
CLI::Validator picture_name();

/// The cores of this machine.
int default_threads();
/// Declares --threads, of which the default is all of them.
void add_threads(CLI::App& command, int& threads);

}  // namespace weft::tools
