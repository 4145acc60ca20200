#include "verbs/common/declared.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <type_traits>
#include <utility>

namespace biss::verbs {
namespace {

template <class Number>
bool convert(const std::string& text, Number& target) {
  char* end = nullptr;
  if constexpr (std::is_floating_point_v<Number>) {
    target = static_cast<Number>(std::strtold(text.c_str(), &end));
  } else if constexpr (std::is_signed_v<Number>) {
    target = std::strtoll(text.c_str(), &end, 0);
  } else {
    target = std::strtoull(text.c_str(), &end, 0);
  }
  return *end == '\0';
}

bool convert(const std::string& text, std::string& target) {
  target = text;
  return true;
}

template <class Value>
bool convert_all(const std::vector<std::string>& texts, Value& target) {
  return convert(texts.back(), target);
}

template <class Value>
bool convert_all(const std::vector<std::string>& texts, std::vector<Value>& target) {
  target.clear();
  return std::all_of(texts.begin(), texts.end(),
                     [&](const std::string& text) { return convert(text, target.emplace_back()); });
}

template <class T>
bool contains(const std::vector<T>& list, const T& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

}  // namespace

void give(Option& option, const std::string& value) {
  if (option.separator == '\0' || value.find(option.separator) == std::string::npos) {
    option.given.push_back(value);
    return;
  }
  std::istringstream values(value);
  for (std::string each; std::getline(values, each, option.separator);) {
    if (!each.empty()) option.given.push_back(each);
  }
}

void set_given(const DeclaredVerb& verb) {
  for (const Option& option : verb.options) {
    if (option.given.empty()) continue;
    if (!option.is_flag() && contains(option.given, std::string())) {
      wrong_value(option.name(), empty_value);
    }
    if (!option.repeats && option.given.size() > 1) {
      throw WrongUsage(option.name() + " is given more than once");
    }
    for (const std::string& value : option.given) {
      if (option.choices.empty() || contains(option.choices, value)) continue;
      wrong_value(option.name(),
                  fmt::format("'{}' is not one of {}", value, fmt::join(option.choices, ", ")));
    }
    if (option.set && !option.set(option.given)) {
      throw WrongUsage(
          fmt::format("Could not convert: {} = {}", option.name(), fmt::join(option.given, ",")));
    }
  }
}

void check_given(const DeclaredVerb& verb) {
  for (const Option& option : verb.options) {
    if (option.given.empty()) {
      if (option.is_required) throw WrongUsage(option.name() + " is required");
      continue;
    }
    for (const Option* needed : option.needed) {
      if (needed->given.empty()) throw WrongUsage(option.name() + " requires " + needed->name());
    }
    for (const Option& other : verb.options) {
      if (other.given.empty() || !contains(option.excluded, &other)) continue;
      throw WrongUsage(option.name() + " excludes " + other.name());
    }
  }
  const auto is_chosen = [](const DeclaredVerb& below) { return below.parsed; };
  if (verb.needs_verb() && find_record(verb.verbs, is_chosen) == nullptr) {
    throw WrongUsage("no verb given");
  }
}

Option& Verb::add_option(const std::string& name, Target target,
                         const std::string& description) const {
  // In the order of Target.
  constexpr std::array<const char*, 5> values{"TEXT", "INT", "TEXT", "FLOAT", "UINT"};
  const bool repeats = target.index() > 1;
  return declared(name, values[target.index()], description, repeats, [target](const auto& texts) {
    return std::visit([&](auto place) { return convert_all(texts, place.get()); }, target);
  });
}

Option& Verb::add_flag(const std::string& name, bool& target,
                       const std::string& description) const {
  return declared(name, "", description, true, [&target](const auto& texts) {
    target = texts.back() == "true" || texts.back() == "1";
    return target || texts.back() == "false" || texts.back() == "0";
  });
}

Option& Verb::add_text_option(const std::string& name, std::function<void(const std::string&)> set,
                              const std::string& description, bool repeats) const {
  return declared(name, "TEXT", description, repeats, [set = std::move(set)](const auto& texts) {
    std::for_each(texts.begin(), texts.end(), set);
    return true;
  });
}

Option& Verb::declared(const std::string& names, const std::string& value,
                       const std::string& meaning, bool repeats, SetValues set) const {
  Option& option = verb_->options.emplace_back();
  option.names = names;
  option.value = value;
  option.meaning = meaning;
  option.heading = heading_;
  option.scope = names.starts_with('-') ? scope_ : Scope::command;
  option.repeats = repeats;
  option.set = std::move(set);
  return option;
}

void Verb::after_parsing(std::function<void()> check) const {
  verb_->checks.push_back(std::move(check));
}

Option& Verb::get_option(const std::string& name) const {
  Option* const found = find_named(verb_->options, name);
  if (found == nullptr) throw std::logic_error("no option " + name);
  return *found;
}

std::vector<const Option*> Verb::given_options() const {
  std::vector<const Option*> given;
  for (const Option& option : verb_->options) {
    if (!option.given.empty()) given.push_back(&option);
  }
  return given;
}

Verb Verb::add_verb(const VerbText& text, Run run) const {
  verb_->verbs.push_back({text, std::move(run)});
  const Verb below(&verb_->verbs.back());
  below.add_help_flag();
  return below;
}

void Verb::add_help_flag() const {
  scope(Scope::command).declared("-h,--help", "", "Print this help", true, {});
}

void Verb::on_run(Run run) const { verb_->run = std::move(run); }

bool Verb::parsed() const { return verb_->parsed; }

void wrong_value(const std::string& name, const std::string& why) {
  throw WrongUsage(name + ": " + why);
}

void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs) {
  const Verb above = command.add_verb(group, {});
  for (const GroupVerb& each : verbs) {
    const Verb below = above.add_verb(each.text);
    below.on_run(each.add(below));
  }
}

}  // namespace biss::verbs
