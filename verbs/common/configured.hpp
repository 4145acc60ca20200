// The result of a configuration as text.
#pragma once

#include <string>
#include <vector>

#include "biss/configure/configuration.hpp"
#include "report/summary.hpp"

namespace biss::verbs {

/// True for the steps that concern one slave.
bool asks_one(ConfigureStep step);

/// One line: the cause, the step, the slave, and how the access went.
std::string fault_text(const ConfigureFault& fault);

/// ConfigureOptions::findings that makes a line of each finding. \pre lines outlives the taker
EdsFindingTaker lines_of_findings(std::vector<std::string>& lines);

/// Adds the slaves, the format and the timing, each with its source, if they were found; and the
/// findings about the data sheets.
void add_configuration(report::Summary& out, const Result<Configuration, ConfigureFault>& found,
                       const std::vector<std::string>& findings);

}  // namespace biss::verbs
