// A SpiDevice as a file, by FUSE: unmodified programs use it as /dev/spidevB.C. The kernel passes
// each ioctl on as one request, and the buffers of a message are reached through the process.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "live/spi_device.hpp"

namespace biss::live {

class SpiMount {
 public:
  /// \param device outlives it
  /// \param before_reply is called when a message is done, before the program learns of it
  SpiMount(SpiDevice& device, std::function<void()> before_reply);
  ~SpiMount();

  /// Mounts it on this empty regular file. \return empty, or why not, with the remedy
  std::string mount(const std::string& path);
  /// Serves a mount that belongs to this open descriptor of /dev/fuse, and closes it at the end. The
  /// file belongs to user 0 of the namespace that mounted it.
  void adopt(int descriptor);

  /// Programs that have it open get errors from now on, also those that wait. The last call; the
  /// destructor does the same.
  void unmount();

  /// Readable if there is a request.
  int descriptor() const;
  /// Serves one request. \return false: it was unmounted
  bool serve();

  /// One line of text, once: why the memory of a program could not be reached.
  std::string take_warning();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Why /dev/fuse cannot be opened with this error of errno, and the remedy.
std::string fuse_problem(int error);

}  // namespace biss::live
