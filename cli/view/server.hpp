// The HTTP server of `biss view`: one thread, bounded in all that a client can ask for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cli/view/answer.hpp"

namespace biss::cli {

class PageServer {
 public:
  /// \param page,capture outlive this; `page` gives parts of `capture`
  PageServer(ServedPage& page, const ServedCapture& capture);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Listens at 127.0.0.1, at any free port for 0. \return one line why not, else empty
  std::string listen(std::uint16_t port);
  std::uint16_t port() const;

  /// Answers until SIGINT, SIGTERM or SIGHUP. \pre listen() has succeeded
  void run();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace biss::cli
