#include <volccd/program/own_process.hpp>

#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <system_error>
#include <thread>

#include <volccd/core/error.hpp>
#include <volccd/program/progress.hpp>

extern char** environ;

namespace volccd {

namespace {

constexpr std::chrono::milliseconds kPoll(20);

/// Starts the program as the first of a group of processes of its own, so that Ctrl-C reaches it once, through
/// wait_for().
pid_t start(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::fflush(nullptr);  // what this process has printed comes first
  pid_t process = 0;
  const int failed = posix_spawn(&process, "/proc/self/exe", nullptr, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (failed == 0) return process;
  throw Error("another process of this program cannot be started: " + std::generic_category().message(failed));
}

int wait_for(pid_t process) {
  int status = 0;
  for (bool told = false;; std::this_thread::sleep_for(kPoll)) {
    const pid_t ended = waitpid(process, &status, WNOHANG);
    if (ended == process) return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (ended < 0 && errno != EINTR)
      throw Error("another process of this program is lost: " + std::generic_category().message(errno));
    if (told || !InterruptGuard::interrupted()) continue;
    kill(process, SIGINT);
    told = true;
  }
}

}  // namespace

int run_own_process(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"volccd"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return wait_for(start(std::move(words)));
}

}  // namespace volccd
