// Numbers in words, in a program whose locale has a decimal comma too.
#include "tools/common/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <locale>
#include <optional>
#include <string>

#include "engine/simulate/network_model.h"
#include "graph/adaptation/checkpoint_files.h"
#include "graph/dataflow/dump/graph_drawing.h"
#include "graph/dataflow/dump/graph_files.h"
#include "weft/weft.h"

namespace weft::tools::numbers_test {
namespace {

TEST(ParseNumber, TakesWhatStrtodTakes) {
  for (const char* text : {"0.5", " 0.5", "+.5", "5e-1", "5E-1", "0x1p-1", "0X.8"})
    EXPECT_EQ(parse_number(text), 0.5) << text;
  EXPECT_EQ(parse_number("-3"), -3);
  EXPECT_EQ(parse_number("-inf"), -std::numeric_limits<double>::infinity());
  EXPECT_NE(parse_number("nan"), parse_number("nan"));
  for (const char* text : {"", " ", "small", "1,5", "1.5 ", "1.5x", "--1", "+-1", "0x", "1e", "1e999"})
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
}

TEST(ParseSize, TakesUnits) {
  EXPECT_EQ(parse_size("8e9"), 8e9);
  EXPECT_EQ(parse_size("100b"), 100);
  for (const char* text : {"3M", "3m", "3MB", "3MiB", "3 mb", "3145728"})
    EXPECT_EQ(parse_size(text), 3 * 1024 * 1024) << text;
  EXPECT_EQ(parse_size("1.5K"), 1536);
  EXPECT_EQ(parse_size("2E"), 2 * std::pow(2.0, 60));
  for (const char* text : {"", "G", "8X", "8GG", "8iB", "much"})
    EXPECT_EQ(parse_size(text), std::nullopt) << text;
}

TEST(ParseSize, IsThatOfTheOptionByName) {
  Options options;
  set_option(options, "max-memory", "8G");
  EXPECT_EQ(options.run.max_memory, 8.0 * 1024 * 1024 * 1024);
  EXPECT_EQ(get_option(options, "max-memory"), "8589934592");
  EXPECT_THROW(set_option(options, "max-memory", "8X"), OptionError);
}

/// Streams write numbers with this in a locale of the program's.
class Comma : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// C and C++ have a decimal comma in this test, by a locale made for it.
class InALocaleWithDecimalComma : public ::testing::Test {
 protected:
  InALocaleWithDecimalComma() {
    std::string name = (std::filesystem::temp_directory_path() / "weft-locale-XXXXXX").string();
    folder_ = mkdtemp(name.data());
    const std::string make = "localedef -i de_DE -f UTF-8 '" + (folder_ / "de_DE.UTF-8").string() + "'";
    made_ = std::system(make.c_str()) == 0;
    setenv("LOCPATH", folder_.c_str(), 1);
    std::locale::global(std::locale(std::locale::classic(), new Comma));
    std::setlocale(LC_ALL, "de_DE.UTF-8");
  }
  ~InALocaleWithDecimalComma() override {
    std::setlocale(LC_ALL, "C");
    std::locale::global(std::locale::classic());
    unsetenv("LOCPATH");
    std::filesystem::remove_all(folder_);
  }
  void SetUp() override {
    if (std::string(std::localeconv()->decimal_point) != ",")
      GTEST_SKIP() << "no locale with a decimal comma" << (made_ ? "" : ": localedef has made none");
  }

 private:
  std::filesystem::path folder_;
  bool made_ = false;
};

TEST_F(InALocaleWithDecimalComma, OptionsAreReadAsEver) {
  Options options;
  set_option(options, "hmin", "0.25");
  EXPECT_EQ(options.metric.hmin, 0.25);
  EXPECT_EQ(get_option(options, "hmin"), "0.25");
  EXPECT_THROW(set_option(options, "hmin", "0,25"), OptionError);
  options.metric.function = "uniform:0.5";
  EXPECT_DOUBLE_EQ(make_metric(box({}), options.metric).metric.tensor(0).xx, 4);
  EXPECT_DOUBLE_EQ(engine::parse_network("1.5us,2.5GB/s").bandwidth, 2.5e9);
}

TEST_F(InALocaleWithDecimalComma, FilesAreWrittenAndReadAsEver) {
  using namespace graph::dataflow;
  Drawing drawing;
  DrawnVertex vertex;
  vertex.weight = 0.5;
  vertex.attributes = {{"seconds", 0.5}};
  drawing.vertices = {vertex};
  EXPECT_THAT(dot_of(drawing), ::testing::HasSubstr("margin=0.08"));
  EXPECT_THAT(graphml_of(drawing), ::testing::HasSubstr(">0.5<"));
  graph::adaptation::CheckpointManifest manifest;
  manifest.run = 1234567;
  manifest.home_ranks = 1;
  manifest.file_sizes = {1234567};
  EXPECT_THAT(manifest.text(), ::testing::HasSubstr("run 1234567\n"));
  EXPECT_TRUE(graph::adaptation::CheckpointManifest::parse(manifest.text()));
}

}  // namespace
}  // namespace weft::tools::numbers_test
