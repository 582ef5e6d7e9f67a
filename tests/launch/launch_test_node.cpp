// A program for the tests of launches that is no node: it does what --param tells it.
//   say:=TEXT prints it; after:=SECONDS then exit:=CODE or signal:=NUMBER; stubborn:=true ignores
//   SIGINT and SIGTERM; touch:=FILE appends a line with its pid; linger:=SECONDS ends that long
//   after SIGINT, with exit:=CODE, having written finished:=FILE.

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

namespace {

volatile sig_atomic_t interrupted = 0;

// In slices, so that SIGINT is seen.
void sleep_unless_interrupted(double seconds) {
  for (int slice = 0; slice < seconds * 100 && !interrupted; ++slice) ::usleep(10'000);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "--describe") {
    std::puts("{\"name\": \"launch_test_node\", \"failure\": \"it takes what it is given\"}");
    return 0;
  }
  std::map<std::string, std::string> parameters;
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string word = argv[i + 1];
    const auto split = word.find(":=");
    if (std::string(argv[i]) == "--param")
      parameters[word.substr(0, split)] = word.substr(split + 2);
  }
  if (parameters.count("stubborn")) {
    ::signal(SIGINT, SIG_IGN);
    ::signal(SIGTERM, SIG_IGN);
  }
  if (parameters.count("linger")) ::signal(SIGINT, [](int) { interrupted = 1; });
  if (parameters.count("touch")) {
    std::ofstream(parameters["touch"], std::ios::app) << getpid() << "\n";
  }
  if (parameters.count("print")) {
    const char* value = std::getenv(parameters["print"].c_str());
    std::printf("%s=%s\n", parameters["print"].c_str(), value ? value : "(not set)");
  }
  if (parameters.count("say")) std::printf("%s\n", parameters["say"].c_str());
  std::fflush(stdout);
  const double seconds = parameters.count("after") ? std::atof(parameters["after"].c_str()) : 100;
  sleep_unless_interrupted(seconds);
  if (interrupted) {
    ::usleep(static_cast<useconds_t>(std::atof(parameters["linger"].c_str()) * 1e6));
    if (parameters.count("finished")) std::ofstream(parameters["finished"]) << "finished";
  }
  if (parameters.count("signal")) ::raise(std::atoi(parameters["signal"].c_str()));
  return parameters.count("exit") ? std::atoi(parameters["exit"].c_str()) : 0;
}
