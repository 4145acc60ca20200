// The HTTP server of `biss view`: one thread, with a limit on everything that a client can request.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cli/view/answer.hpp"

namespace biss::cli {

/// Listens at 127.0.0.1, at any free port for 0, sets the port of `page`, and answers until SIGINT,
/// SIGTERM or SIGHUP.
/// \param page gives parts of `capture`
/// \param on_listening is called once, before the first answer; false ends the server
/// \return one line why it cannot listen, else empty
std::string serve(ServedPage& page, const ServedCapture& capture, std::uint16_t port,
                  const std::function<bool()>& on_listening);

}  // namespace biss::cli
