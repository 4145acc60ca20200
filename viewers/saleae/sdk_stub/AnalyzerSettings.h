// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <LogicPublicTypes.h>

#include <string>
#include <vector>

class AnalyzerSettingInterface {
 public:
  virtual ~AnalyzerSettingInterface() = default;
  void SetTitleAndTooltip(const char*, const char*) {}
};

class AnalyzerSettingInterfaceChannel : public AnalyzerSettingInterface {
 public:
  Channel GetChannel() { return channel_; }
  void SetChannel(const Channel& channel) { channel_ = channel; }

 private:
  Channel channel_;
};

class AnalyzerSettingInterfaceText : public AnalyzerSettingInterface {
 public:
  const char* GetText() { return text_.c_str(); }
  void SetText(const char* text) { text_ = text; }

 private:
  std::string text_;
};

class AnalyzerSettingInterfaceBool : public AnalyzerSettingInterface {
 public:
  bool GetValue() { return value_; }
  void SetValue(bool value) { value_ = value; }
  void SetCheckBoxText(const char*) {}

 private:
  bool value_ = false;
};

class AnalyzerSettings {
 public:
  virtual ~AnalyzerSettings() = default;
  virtual bool SetSettingsFromInterfaces() = 0;
  virtual void LoadSettings(const char* settings) = 0;
  virtual const char* SaveSettings() = 0;

  // Only of this stub.
  std::vector<AnalyzerSettingInterface*> fields;
  std::string error;

 protected:
  void ClearChannels() {}
  void AddChannel(Channel&, const char*, bool) {}
  void SetErrorText(const char* text) { error = text; }
  void AddInterface(AnalyzerSettingInterface* field) { fields.push_back(field); }
  void AddExportOption(U32, const char*) {}
  void AddExportExtension(U32, const char*, const char*) {}
  const char* SetReturnString(const char* text) {
    returned_ = text;
    return returned_.c_str();
  }

 private:
  std::string returned_;
};
