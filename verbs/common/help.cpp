#include "verbs/common/help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "verbs/common/wrap.hpp"

namespace biss::verbs {
namespace {

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
  append_wrapped(out, text, {text_column, text_column, help_width});
  out += '\n';
}

std::string label_of(const OptionHelp& option) {
  return option.value.empty() ? option.name : option.name + ' ' + option.value;
}

std::string label_text(const OptionHelp& option) {
  const bool argument = option.heading.empty();
  return option.required && !argument ? option.text + " (required)" : option.text;
}

// Headings in the order of their first option. `Options` is among them for the manual; the help
// prints it last.
std::vector<std::string> headings_of(const VerbHelp& verb) {
  std::vector<std::string> headings;
  for (const OptionHelp& option : verb.options) {
    if (option.heading.empty()) continue;
    if (std::find(headings.begin(), headings.end(), option.heading) == headings.end()) {
      headings.push_back(option.heading);
    }
  }
  return headings;
}

std::string usage_of(const VerbHelp& verb) {
  std::string usage = verb.name;
  for (const OptionHelp& option : verb.options) {
    if (option.required && !option.heading.empty()) usage += ' ' + label_of(option);
  }
  usage += " [OPTION]...";
  for (const OptionHelp& option : verb.options) {
    if (!option.heading.empty()) continue;
    usage += option.required ? ' ' + option.name : " [" + option.name + ']';
  }
  if (!verb.verbs.empty())
    usage += verb.options.size() > 1 && verb.name != "biss" ? " [VERB]" : " VERB";
  return usage;
}

template <class Wanted>
void append_options(std::string& out, const VerbHelp& verb, const std::string& title,
                    const Wanted& wanted) {
  bool first = true;
  for (const OptionHelp& option : verb.options) {
    if (!wanted(option)) continue;
    if (first) out += '\n' + title + ":\n";
    first = false;
    append_entry(out, label_of(option), label_text(option));
  }
}

}  // namespace

std::string help_text(const VerbHelp& verb) {
  std::string out;
  append_wrapped(out, verb.purpose + '.', {0, 0, help_width});
  out += "\n\nUsage: ";
  append_wrapped(out, usage_of(verb), {7, 9, help_width});
  out += '\n';
  append_options(out, verb, "Arguments",
                 [](const OptionHelp& option) { return option.heading.empty(); });
  for (const std::string& heading : headings_of(verb)) {
    append_options(out, verb, heading,
                   [&](const OptionHelp& option) { return option.heading == heading; });
  }
  if (!verb.verbs.empty()) out += "\nVerbs:\n";
  for (const VerbHelp& below : verb.verbs) {
    append_entry(out, below.name.substr(below.name.rfind(' ') + 1), below.purpose);
  }
  if (!verb.examples.empty()) out += verb.examples.size() == 1 ? "\nExample:\n" : "\nExamples:\n";
  for (const std::string& example : verb.examples) out += "  " + example + '\n';
  if (!verb.verbs.empty()) {
    out += fmt::format("\n'{} VERB --help' prints the help of a verb.\n", verb.name);
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

void append_manual(std::string& out, const VerbHelp& verb) {
  out += fmt::format(".SS {}\n{}.\n.PP\n.B {}\n", roff(verb.name), roff(verb.purpose),
                     roff(usage_of(verb)));
  for (const OptionHelp& option : verb.options) {
    if (option.name.ends_with("--help")) continue;
    out += fmt::format(".TP\n.B {}\n{}.\n", roff(label_of(option)), roff(label_text(option)));
  }
  if (!verb.examples.empty()) out += ".PP\nExamples:\n.PP\n.nf\n";
  for (const std::string& example : verb.examples) out += "    " + roff(example) + '\n';
  if (!verb.examples.empty()) out += ".fi\n";
  for (const VerbHelp& below : verb.verbs) append_manual(out, below);
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

std::string man_page(const VerbHelp& command, std::string_view version) {
  std::string out = fmt::format(
      ".TH BISS 1 \"\" \"biss {}\" \"User Commands\"\n.SH NAME\nbiss \\- toolkit for the BiSS C "
      "encoder interface\n.SH SYNOPSIS\n.B biss\n.I VERB\n[\\fIOPTION\\fR]...\n",
      version);
  out += manual_introduction;
  out += ".SH OPTIONS\n";
  for (const OptionHelp& option : command.options) {
    out += fmt::format(".TP\n.B {}\n{}.\n", roff(label_of(option)), roff(label_text(option)));
  }
  out += ".SH VERBS\n";
  for (const VerbHelp& verb : command.verbs) append_manual(out, verb);
  out += page_end;
  return out;
}

namespace {

// `a b` of `biss a b`; empty for the command itself.
std::string path_of(const VerbHelp& verb) {
  const std::size_t space = verb.name.find(' ');
  return space == std::string::npos ? std::string() : verb.name.substr(space + 1);
}

// All verbs, each before those below it.
void collect(const VerbHelp& verb, std::vector<const VerbHelp*>& all) {
  all.push_back(&verb);
  for (const VerbHelp& below : verb.verbs) collect(below, all);
}

// The words of `-f, --format`.
std::vector<std::string> words_of(const OptionHelp& option) {
  std::vector<std::string> words;
  std::string_view rest_of = option.name;
  while (!rest_of.empty()) {
    const std::size_t end = std::min(rest_of.find(", "), rest_of.size());
    words.emplace_back(rest_of.substr(0, end));
    rest_of.remove_prefix(std::min(end + 2, rest_of.size()));
  }
  return words;
}

// `table|csv|jsonl` lists values; `N|TIME` names kinds of values.
bool lists_values(const OptionHelp& option) {
  return option.value.find('|') != std::string::npos &&
         std::none_of(option.value.begin(), option.value.end(),
                      [](char c) { return c >= 'A' && c <= 'Z'; });
}

}  // namespace

std::string bash_completion(const VerbHelp& command) {
  std::vector<const VerbHelp*> all;
  collect(command, all);
  std::string paths;
  std::string values;
  std::string words;
  for (const VerbHelp* verb : all) {
    const std::string path = path_of(*verb);
    if (!path.empty()) paths += fmt::format("{}'{}'", paths.empty() ? "" : "|", path);
    std::string options;
    for (const OptionHelp& option : verb->options) {
      if (option.heading.empty()) continue;
      for (const std::string& word : words_of(option)) {
        options += ' ' + word;
        std::string list = option.value;
        std::replace(list.begin(), list.end(), '|', ' ');
        if (lists_values(option)) {
          values += fmt::format("    '{} {}') list='{}' ;;\n", path, word, list);
        }
      }
    }
    std::string verbs;
    for (const VerbHelp& below : verb->verbs) {
      verbs += ' ' + below.name.substr(below.name.rfind(' ') + 1);
    }
    words += fmt::format("    '{}') options='{}' verbs='{}' ;;\n", path,
                         options.substr(std::min<std::size_t>(options.size(), 1)),
                         verbs.substr(std::min<std::size_t>(verbs.size(), 1)));
  }
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
                     paths, values, words);
}

}  // namespace biss::verbs
