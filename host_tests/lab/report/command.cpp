// SPDX-License-Identifier: BSD-3-Clause
// m100-lab report: joins the pages that other subcommands wrote into one self-contained page.
#include <filesystem>
#include <iostream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/plot/html.h"
#include "host_tests/lab/plot/svg.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/report/summary.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct ReportOptions {
  std::string out;
  std::string title = "Matrice 100: identified, flown, compared";
  std::string lead;
  std::string note;
  report::Sources sources;
  std::vector<std::string> pages;
};

/// The text between the first `from` and the last `to`. @throws InputError naming the page: there is none.
std::string between(const std::string& page, const std::string& html, const std::string& from, const std::string& to) {
  const std::size_t begin = html.find(from);
  const std::size_t end = html.rfind(to);
  if (begin == std::string::npos || end == std::string::npos || end < begin + from.size()) {
    throw InputError(page, 0, from, "this is not a page that m100-lab wrote");
  }
  return html.substr(begin + from.size(), end - begin - from.size());
}

/// The path of a page relative to the folder of the written page, so that it is valid for the reader.
std::string seen_from(const std::string& out, const std::string& page) {
  std::error_code none;
  const std::filesystem::path folder = std::filesystem::absolute(out, none).parent_path();
  const std::filesystem::path way = std::filesystem::absolute(page, none).lexically_normal();
  return way.lexically_relative(folder.lexically_normal()).generic_string();
}

void run(const ReportOptions& options) {
  companion::FileUse()
      .reads("pages", options.pages)
      .reads("--lead", options.lead)
      .reads("--identified", options.sources.identified)
      .reads("--experiments", options.sources.experiments)
      .reads("--loop", options.sources.loop)
      .reads("--margins", options.sources.margins)
      .writes("--out", options.out)
      .check();
  plot::Page whole(options.title);
  if (options.sources.any()) {
    report::summarise(options.sources, whole);
  } else if (!options.sources.asked.empty()) {
    whole.paragraph("Asked: " + options.sources.asked);
  }
  if (!options.note.empty()) {
    whole.paragraph(options.note);
  }
  if (!options.lead.empty()) {
    whole.raw(between(options.lead, whole_file(options.lead), plot::kHeadEnds, "</body>"));
  }
  std::string contents = "<ul>\n";
  std::string bodies;
  for (std::size_t i = 0; i < options.pages.size(); ++i) {
    const std::string html = whole_file(options.pages[i]);
    const std::string anchor = "part" + std::to_string(i + 1);
    contents += "<li><a href=\"#" + anchor + "\">" + between(options.pages[i], html, "<title>", "</title>") + "</a> (" +
                plot::escape(seen_from(options.out, options.pages[i])) + ")</li>\n";
    bodies += "<section id=\"" + anchor + "\">" + between(options.pages[i], html, "<body>", "</body>") + "</section>\n";
  }
  whole.heading("In detail");
  whole.raw(contents + "</ul>\n" + bodies);
  whole.write(options.out);
  std::cout << "wrote " << printable(options.out) << "\n";
}

}  // namespace

void add_report(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<ReportOptions>(
      "report", "join the pages of identify, gains, experiments and loop into one", run);
  command.add_option("pages", options->pages, "pages (HTML) in their order").required();
  command.add_option("--out", options->out, "the page to write").required();
  command.add_option("--title", options->title, "its title");
  command.add_option("--lead", options->lead, "page (HTML) to show on the first screen, before the links");
  command.add_option("--asked", options->sources.asked, "the question that the page answers, shown on its first line");
  command.add_option("--note", options->note, "a sentence under the title");
  command.add_option("--identified", options->sources.identified,
                     "result of identify (JSON), for the summary; may be repeated");
  command.add_option("--source", options->sources.origin, "origin of the identified logs; default: not stated")
      .one_of({"measured", "simulated"});
  command.add_option("--experiments", options->sources.experiments, "result of experiments (JSON), for the summary");
  command.add_option("--loop", options->sources.loop, "result of loop (JSON), for the summary");
  command.add_option("--margins", options->sources.margins, "result of gains (JSON), for the summary");
}

}  // namespace m100::lab
