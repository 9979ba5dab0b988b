// Time of one batch of verdicts on 10⁶ uniform random configurations through the C++ wrapper, with a digest of the verdicts:
// the counterpart of crates/measure/src/bin/batch_verdicts.rs, which cpp_is_free.py compares with it.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>

#include <cranny/cranny.hpp>

int main(int, char** words) {
  constexpr std::size_t kCount = 1'000'000;
  const cranny::Scenario scenario(words[1]);
  const cranny::Cell cell = scenario.cell();
  const cranny::Rows q = scenario.robot().sample(kCount, 0);
  const std::unique_ptr<bool[]> verdicts(new bool[kCount]);
  // The first round warms caches and pages.
  cell.are_free(q, verdicts.get());
  const auto begin = std::chrono::steady_clock::now();
  cell.are_free(q, verdicts.get());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  // FNV-1a, 64 bits.
  std::uint64_t digest = 0xcbf29ce484222325;
  std::size_t free = 0;
  for (std::size_t row = 0; row < kCount; ++row) {
    digest = (digest ^ static_cast<std::uint64_t>(verdicts[row])) * 0x100000001b3;
    free += verdicts[row];
  }
  std::printf("%.6f %zu %016llx\n", seconds.count(), free, static_cast<unsigned long long>(digest));
}
