// Checks of option values beyond the parser's own, which accept NaN and infinity; defaults that commands
// share.
#pragma once

#include <CLI/CLI.hpp>

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

/// The name of a picture.
CLI::Validator picture_name();

/// The cores of this machine.
int default_threads();
/// Declares --threads, of which the default is all of them.
void add_threads(CLI::App& command, int& threads);

}  // namespace weft::tools
