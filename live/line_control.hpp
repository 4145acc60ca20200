// The control communication over a port whose MA is the data output: CDM is a part of the transfer.
#pragma once

#include <functional>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/control/session.hpp"
#include "biss/frame/frame.hpp"
#include "live/line_reader.hpp"
#include "live/spi_port.hpp"

namespace biss::live {

class LineControl {
 public:
  /// \param port with MaPin::mosi
  /// \param clock of the port, 250 kHz to 1 MHz, which every slave accepts
  /// \param go_on asked before each request
  LineControl(SpiPort port, Hertz clock, std::function<bool()> go_on);

  /// Makes requests until a Configurator or a ControlSession is done.
  /// \return false: go_on() was false, the port was gone, or ten transfers in a row failed
  template <class Master>
  bool run(Master& master) {
    while (!master.done()) {
      const auto cds = request(master.cdm_ahead());
      if (!cds) return false;
      master.take_cds(time_, *cds);
    }
    return true;
  }
  /// The last fault of the port since a transfer succeeded.
  std::optional<PortFault> fault() const { return fault_; }

 private:
  std::optional<CdsBit> request(bool cdm);

  FrameBounds bounds_;
  LineReader reader_;
  std::function<bool()> go_on_;
  Picoseconds time_{};  // of the last request
  unsigned faults_in_a_row_ = 0;
  std::optional<PortFault> fault_;
};

}  // namespace biss::live
