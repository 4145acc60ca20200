// The exit status of the command.
#pragma once

namespace biss::verbs {

/// Exit status of every verb.
enum class ExitStatus : int {
  done = 0,         ///< the verb did its work
  data_failed = 1,  ///< the data failed: a check with findings, or no request cycle
  usage = 2,        ///< the command line is wrong; nothing was read or written
  io = 3,           ///< input unreadable or malformed, output not written, out of memory
};

}  // namespace biss::verbs
