// What the command's exit status says: the same for every subcommand.
#pragma once

namespace weft::tools {

enum ExitCode : int {
  kDone = 0,
  kGoalNotMet = 1,  ///< a valid mesh was written, but interrupted, far from the request, or worse on its CAD
                    ///< model than the input; `verify`: does not conform
  kNoMesh = 2,      ///< bad input or a failure; nothing was written
  kUsage = 64,      ///< the command line makes no sense (EX_USAGE)
};

}  // namespace weft::tools
