#include "verbs/common/help.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "report/text.hpp"

namespace biss::verbs {
namespace {

// An example is never broken.
constexpr std::size_t help_width = 100;
constexpr std::size_t text_column = 28;

// `  NAME   text`, the text in a second column. A long list of values is broken after a `|`.
void append_entry(std::string& out, const std::string& name, std::string_view text) {
  std::string line = "  " + name;
  while (line.size() > help_width) {
    const std::size_t bar = line.rfind('|', help_width - 1);
    if (bar == std::string::npos) break;
    out += line.substr(0, bar + 1) + '\n';
    line = std::string(6, ' ') + line.substr(bar + 1);
  }
  if (line.size() + 2 > text_column) {
    out += line + '\n' + std::string(text_column, ' ');
  } else {
    out += line + std::string(text_column - line.size(), ' ');
  }
  report::append_wrapped(out, text, {text_column, text_column, help_width});
  out += '\n';
}

// `-f, --format FORMAT`, or `FILE...` for an argument.
std::string label_of(const Option& option) {
  if (option.is_argument()) return option.names + (option.repeats ? "..." : "");
  std::string label = option.names;
  if (const std::size_t comma = label.find(','); comma != std::string::npos) {
    label.insert(comma + 1, " ");
  }
  return option.is_flag() ? label : label + ' ' + option.value;
}

std::string label_text(const Option& option) {
  return option.meaning + (option.is_required && !option.is_argument() ? " (required)" : "");
}

// The command has the first example of each verb.
std::vector<std::string> examples_of(const DeclaredVerb& verb, const std::string& path) {
  std::vector<std::string> examples = verb.text.examples;
  if (path != "biss") return examples;
  for (const DeclaredVerb& below : verb.verbs) {
    if (!below.text.examples.empty()) examples.push_back(below.text.examples.front());
  }
  return examples;
}

std::string heading_of(const Option& option) {
  return option.is_argument() ? "Arguments" : option.heading;
}

// Options under their headings, in the order of the first option; arguments are first.
void append_options(std::string& out, const DeclaredVerb& verb) {
  std::vector<std::string> headings{"Arguments"};
  for (const Option& option : verb.options) {
    if (std::find(headings.begin(), headings.end(), heading_of(option)) == headings.end()) {
      headings.push_back(heading_of(option));
    }
  }
  for (const std::string& heading : headings) {
    std::string title = '\n' + heading + ":\n";
    for (const Option& option : verb.options) {
      if (heading_of(option) != heading) continue;
      out += std::exchange(title, {});
      append_entry(out, label_of(option), label_text(option));
    }
  }
}

std::string usage_of(const DeclaredVerb& verb, const std::string& path) {
  std::string usage = path;
  for (const Option& option : verb.options) {
    if (option.is_required && !option.is_argument()) usage += ' ' + label_of(option);
  }
  usage += " [OPTION]...";
  for (const Option& option : verb.options) {
    if (!option.is_argument()) continue;
    usage += fmt::format(fmt::runtime(option.is_required ? " {}" : " [{}]"), label_of(option));
  }
  if (!verb.verbs.empty()) {
    usage += verb.options.size() > 1 && path != "biss" ? " [VERB]" : " VERB";
  }
  return usage;
}

}  // namespace

std::string help_text(const DeclaredVerb& verb, const std::string& path) {
  std::string out;
  report::append_wrapped(out, verb.text.purpose + '.', {0, 0, help_width});
  out += "\n\nUsage: ";
  report::append_wrapped(out, usage_of(verb, path), {7, 9, help_width});
  out += '\n';
  append_options(out, verb);
  if (!verb.verbs.empty()) out += "\nVerbs:\n";
  for (const DeclaredVerb& below : verb.verbs) {
    append_entry(out, below.text.name, below.text.purpose);
  }
  const std::vector<std::string> examples = examples_of(verb, path);
  if (!examples.empty()) out += examples.size() == 1 ? "\nExample:\n" : "\nExamples:\n";
  for (const std::string& example : examples) out += "  " + example + '\n';
  if (!verb.verbs.empty()) {
    out += fmt::format("\n'{} VERB --help' prints the help of a verb.\n", path);
  }
  return out;
}

namespace {

// Text of the manual page: no dash becomes a hyphen and no line becomes a request.
std::string roff(std::string_view text) {
  std::string out;
  if (text.starts_with('.') || text.starts_with('\'')) out += "\\&";
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

void append_manual(std::string& out, const Option& option) {
  out += fmt::format(".TP\n.B {}\n{}.\n", roff(label_of(option)), roff(label_text(option)));
}

void append_manual(std::string& out, const DeclaredVerb& verb, const std::string& path) {
  out += fmt::format(".SS {}\n{}.\n.PP\n.B {}\n", roff(path), roff(verb.text.purpose),
                     roff(usage_of(verb, path)));
  for (const Option& option : verb.options) {
    if (option.name() != "--help") append_manual(out, option);
  }
  const std::vector<std::string> examples = examples_of(verb, path);
  if (!examples.empty()) out += ".PP\nExamples:\n.PP\n.nf\n";
  for (const std::string& example : examples) out += "    " + roff(example) + '\n';
  if (!examples.empty()) out += ".fi\n";
  for (const DeclaredVerb& below : verb.verbs) {
    append_manual(out, below, path + ' ' + below.text.name);
  }
}

constexpr std::string_view manual_introduction = R"(.SH DESCRIPTION
.B biss
reads captures of the BiSS C lines MA and SLO, simulates encoders and masters, reads and writes
electronic data sheets (EDS), and computes how strong the checks of a frame are.
.PP
Data goes to standard output or to the file of
.BR \-o ;
summaries, warnings and errors go to standard error. The name
.B \-
means standard input or standard output. An output file is replaced as a whole when the verb
succeeds; otherwise it stays as it was. A run never writes to a file that it reads.
.PP
A quantity has a unit: 10MHz, 250kHz, 31.25us, 42.5ns, 50m. Only 0 may stand alone.
.PP
A frame format is a list of items in line order, for example pos26,nE,nW,crc6, or a name that
.B biss encoders
lists, or a profile identifier such as bp3:0x621E.
)";

constexpr std::string_view page_end = R"(.SH EXIT STATUS
.TP
.B 0
Success.
.TP
.B 1
The data failed: a check with findings, \-\-fail\-on, or no request cycle found.
.TP
.B 2
Wrong usage. Nothing was read or written.
.TP
.B 3
Input unreadable or malformed, output not written, or out of memory.
.SH ENVIRONMENT
.TP
.B BISS_SIMD
If "none", no vector instructions but those that every processor of this kind has. All results are
the same.
.TP
.B NO_COLOR
If not empty, tables on a terminal have no colours.
.TP
.B TMPDIR
The folder for temporary files that do not belong beside an output; /tmp by default.
)";

}  // namespace

std::string man_page(const DeclaredVerb& command, std::string_view version) {
  std::string out = fmt::format(
      ".TH BISS 1 \"\" \"biss {}\" \"User Commands\"\n.SH NAME\nbiss \\- toolkit for the BiSS C "
      "encoder interface\n.SH SYNOPSIS\n.B biss\n.I VERB\n[\\fIOPTION\\fR]...\n",
      version);
  out += manual_introduction;
  out += ".SH OPTIONS\n";
  for (const Option& option : command.options) append_manual(out, option);
  out += ".SH VERBS\n";
  for (const DeclaredVerb& verb : command.verbs) append_manual(out, verb, "biss " + verb.text.name);
  out += page_end;
  return out;
}

namespace {

// `table|csv|jsonl` lists values; `N|TIME` names kinds of values.
bool lists_values(const Option& option) {
  return option.value.find('|') != std::string::npos &&
         std::none_of(option.value.begin(), option.value.end(),
                      [](char c) { return c >= 'A' && c <= 'Z'; });
}

// The parts of the script for each verb.
struct Completion {
  std::string paths{};
  std::string values{};
  std::string words{};

  void add(const DeclaredVerb& verb, const std::string& path) {
    if (!path.empty()) paths += fmt::format("{}'{}'", paths.empty() ? "" : "|", path);
    std::vector<std::string> options;
    for (const Option& option : verb.options) {
      if (option.is_argument()) continue;
      std::istringstream names(option.names);
      for (std::string name; std::getline(names, name, ',');) {
        options.push_back(name);
        std::string list = option.value;
        std::replace(list.begin(), list.end(), '|', ' ');
        if (lists_values(option)) {
          values += fmt::format("    '{} {}') list='{}' ;;\n", path, name, list);
        }
      }
    }
    std::vector<std::string> verbs;
    for (const DeclaredVerb& below : verb.verbs) verbs.push_back(below.text.name);
    words += fmt::format("    '{}') options='{}' verbs='{}' ;;\n", path, fmt::join(options, " "),
                         fmt::join(verbs, " "));
    for (const DeclaredVerb& below : verb.verbs) {
      add(below, path + (path.empty() ? "" : " ") + below.text.name);
    }
  }
};

}  // namespace

std::string bash_completion(const DeclaredVerb& command) {
  Completion parts;
  parts.add(command, "");
  return fmt::format(R"(# bash completion for biss, made by 'biss help --to bash'
_biss() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local verb='' word list='' options='' verbs='' i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word="${{verb:+$verb }}${{COMP_WORDS[i]}}"
    case "$word" in
      {}) verb=$word ;;
      *) break ;;
    esac
  done
  case "$verb $before" in
{}    *' -f'|*' --format') list=$(biss encoders --to csv 2>/dev/null | sed -n 's/^\([a-z][a-z0-9-]*\),.*/\1/p') ;;
  esac
  if [[ -n $list ]]; then
    COMPREPLY=($(compgen -W "$list" -- "$current"))
    return
  fi
  case "$verb" in
{}  esac
  if [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
  else
    COMPREPLY=($(compgen -W "$verbs" -- "$current"))
  fi
}}
complete -o default -F _biss biss
)",
                     parts.paths, parts.values, parts.words);
}

namespace {

constexpr std::array<const char*, 5> scope_names{"reading", "file", "judging", "rows", "command"};

nlohmann::json json_of(const DeclaredVerb& verb) {
  nlohmann::json options = nlohmann::json::array();
  for (const Option& option : verb.options) {
    options.push_back({{"names", option.names},
                       {"name", option.name()},
                       {"value", option.value},
                       {"meaning", option.meaning},
                       {"heading", option.heading},
                       {"scope", scope_names[static_cast<std::size_t>(option.scope)]},
                       {"repeats", option.repeats},
                       {"required", option.is_required},
                       {"choices", option.choices}});
  }
  nlohmann::json below = nlohmann::json::array();
  for (const DeclaredVerb& each : verb.verbs) below.push_back(json_of(each));
  return {{"name", verb.text.name}, {"options", options}, {"verbs", below}};
}

}  // namespace

std::string described(const DeclaredVerb& verb) { return json_of(verb).dump(); }

}  // namespace biss::verbs
