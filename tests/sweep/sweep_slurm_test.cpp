// A sweep on a real Slurm of this machine: a controller and a daemon of its own, with keys of their
// own, on the loopback; a job cancelled and submitted again.

#include <pwd.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

bool is_there(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

std::string said(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> part{};
  while (pipe && std::fgets(part.data(), part.size(), pipe)) text += part.data();
  if (pipe) pclose(pipe);
  return text;
}

/// A cluster of one machine in a folder; it ends with the object.
class Cluster {
 public:
  explicit Cluster(const ScratchDirectory& folder) : folder_(folder.path()) {
    for (const char* name : {"state", "spool", "log"}) fs::create_directory(folder_ / name);
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    const std::string name = std::string(host.data()).substr(0, std::string(host.data()).find('.'));
    const int port = 20000 + static_cast<int>(getpid() % 20000);
    std::ofstream configuration(folder_ / "slurm.conf");
    configuration << "ClusterName=test\nSlurmctldHost=" << name
                  << "(127.0.0.1)\nSlurmctldPort=" << port << "\nSlurmdPort=" << port + 1
                  << "\nAuthType=auth/munge\nAuthInfo=socket="
                  << (folder_ / "munge.socket").string()
                  << "\nCryptoType=crypto/munge\nMpiDefault=none\nProctrackType=proctrack/pgid\n"
                     "TaskPlugin=task/none\nSwitchType=switch/none\nReturnToService=2\n"
                     "SchedulerType=sched/backfill\nSchedulerParameters=batch_sched_delay=0\n"
                     "SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\n"
                     "AccountingStorageType=accounting_storage/none\nJobAcctGatherType="
                     "jobacct_gather/none\nSlurmUser=root\nSlurmdUser=root\n"
                  << "StateSaveLocation=" << (folder_ / "state").string()
                  << "\nSlurmdSpoolDir=" << (folder_ / "spool").string()
                  << "\nSlurmctldPidFile=" << (folder_ / "slurmctld.pid").string()
                  << "\nSlurmdPidFile=" << (folder_ / "slurmd.pid").string()
                  << "\nSlurmctldLogFile=" << (folder_ / "log/slurmctld").string()
                  << "\nSlurmdLogFile=" << (folder_ / "log/slurmd").string()
                  << "\nNodeName=" << name
                  << " NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\nPartitionName=all Nodes=" << name
                  << " Default=YES MaxTime=INFINITE State=UP\n";
    configuration.close();
    setenv("SLURM_CONF", (folder_ / "slurm.conf").c_str(), 1);
    begin();
  }
  ~Cluster() {
    said("scancel --full --user=$(id -un)");
    for (const std::string& daemon : {"slurmd", "slurmctld", "munged"}) {
      std::ifstream file(folder_ / (daemon + ".pid"));
      pid_t process = 0;
      if (!(file >> process) || process <= 1) continue;
      ::kill(process, SIGTERM);
      if (!eventually([&] { return !is_running(process); })) ::kill(process, SIGKILL);
    }
  }
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  bool is_up() const {
    return said("sinfo --noheader --format=%T").find("idle") != std::string::npos;
  }
  std::string log() const {
    return started_ + text_of_file(folder_ / "log/slurmctld") +
           text_of_file(folder_ / "log/slurmd");
  }

 private:
  void begin() {
    const std::string place = folder_.string();
    // Slurm looks at who owns what is above these.
    started_ =
        said("dd if=/dev/urandom of=" + place + "/key bs=1 count=1024 status=none && chmod 600 " +
             place + "/key && munged --force --key-file=" + place + "/key --socket=" + place +
             "/munge.socket --pid-file=" + place + "/munged.pid --log-file=" + place +
             "/log/munged --seed-file=" + place + "/seed");
    started_ += said("slurmctld -f " + place + "/slurm.conf");
    started_ += said("slurmd -f " + place + "/slurm.conf");
  }

  const fs::path folder_;
  std::string started_;
};

TEST(SweepSlurm, AnArrayIsCancelledAndGoesOnWhenItIsSubmittedAgain) {
  if (geteuid() != 0) GTEST_SKIP() << "Slurm's daemons need root";
  for (const char* program : {"slurmctld", "slurmd", "munged", "sbatch"}) {
    if (!is_there(program)) GTEST_SKIP() << program << " is not installed";
  }
  const ScratchDirectory folder;
  const Cluster cluster(folder);
  if (!eventually([&] { return cluster.is_up(); }, std::chrono::seconds(30))) {
    FAIL() << "Slurm did not come up: " << cluster.log();
  }
  const std::string description = folder.write("s.yaml", R"(
program: /bin/sh
arguments: [-c, 'sleep 1; echo v={a}']
grid: {a: {from: 1, to: 16}}
results: {output: {v: 'v=(\d+)'}}
)");
  const auto run = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> words{"sweep", description, "--out", folder.path(out)};
    words.insert(words.end(), more.begin(), more.end());
    ChildProgram program("prehend", words, folder.path("output"));
    program.wait(std::chrono::seconds(60));
    return program.output();
  };
  EXPECT_THAT(run("cluster", {"--slurm", "2"}), HasSubstr("sbatch"));
  const std::string submit = "sbatch --parsable " + folder.path("cluster") + "/array.sh";
  const std::string job = said(submit);
  EXPECT_TRUE(eventually(
      [&] {
        const std::string status = run("cluster", {"--status"});
        return status.find(": 0 done") == std::string::npos;
      },
      std::chrono::seconds(40)))
      << job << cluster.log();
  said("scancel " + job);
  const auto is_empty = [] { return said("squeue --noheader").empty(); };
  ASSERT_TRUE(eventually(is_empty, std::chrono::seconds(30)));
  EXPECT_THAT(run("cluster", {"--status"}), ::testing::Not(HasSubstr(" 0 open"))) << "cancelled";
  said(submit);
  ASSERT_TRUE(eventually(is_empty, std::chrono::seconds(60))) << cluster.log();
  const std::string merged = run("cluster", {"--merge", "--export", folder.path("cluster.csv")});
  EXPECT_THAT(merged, HasSubstr("16 done, 0 failed, 0 open"));
  run("here", {"--workers", "16", "--export", folder.path("here.csv")});
  EXPECT_EQ(text_of_file(folder.path("cluster.csv")), text_of_file(folder.path("here.csv")));
}

}  // namespace
}  // namespace prehend::testing
