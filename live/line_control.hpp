// The control communication of a real line whose MA is the data output of the port: CDM is part of
// each transfer, so it is chosen before CDS is known.
#pragma once

#include <functional>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/configure/configure_link.hpp"
#include "live/line_reader.hpp"
#include "live/spi_port.hpp"

namespace biss::live {

class LineControl {
 public:
  /// This many transfers that fail one after the other end the communication.
  static constexpr unsigned most_faults = 10;

  /// \param port with MaPin::mosi
  /// \param clock of the port, 250 kHz to 1 MHz, which every slave accepts
  /// \param go_on asked before each request
  LineControl(SpiPort port, Hertz clock, std::function<bool()> go_on);

  /// Makes the requests until the configuration is done. \pre as for Configurator::cdm_ahead()
  /// \return false: go_on() was false, or the port failed
  bool run(Configurator& configurator);
  /// The same for an access to registers.
  bool run(ControlSession& session);

  /// The fault of the port that ended run().
  std::optional<PortFault> fault() const { return fault_; }

 private:
  struct Answer {
    Picoseconds time{};
    CdsBit cds = CdsBit::missing;
  };
  std::optional<Answer> request(bool cdm);

  FrameBounds bounds_;
  LineReader reader_;
  std::function<bool()> go_on_;
  unsigned faults_in_a_row_ = 0;
  std::optional<PortFault> fault_;
};

}  // namespace biss::live
