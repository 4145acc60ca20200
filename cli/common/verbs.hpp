// The verbs of the command; each is defined in the file of its name.
#pragma once

namespace biss::cli {

class Command;

void add_archive(Command& command);
void add_decode(Command& command);
void add_check(Command& command);
void add_compare(Command& command);
void add_convert(Command& command);
void add_crc(Command& command);
void add_draw(Command& command);
void add_encoders(Command& command);
void add_eds(Command& command);
void add_identify(Command& command);
void add_explain(Command& command);
void add_plan(Command& command);
void add_registers(Command& command);
void add_report(Command& command);
void add_safety(Command& command);
void add_simulate(Command& command);
void add_view(Command& command);

}  // namespace biss::cli
