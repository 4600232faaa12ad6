// Cuts by histograms: local items are sorted once, so that a bin of any histogram is two binary searches.
#include "partition/decompose/ordered_cuts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

constexpr std::uint64_t kEnd = std::numeric_limits<std::uint64_t>::max();
/// What a round sends should take a network about as long as the steps in which it is sent: 32 KB.
constexpr std::size_t kBinsPerRound = std::size_t{1} << 11;
/// Items that are sent in place of another round, together or for each cut.
constexpr std::uint64_t kFewItems = 1024, kFewOfCut = 8;

/// Where items divide: those before (key, number) go left.
struct Threshold {
  std::uint64_t key, number;
};

/// Integers first to last, both included.
struct Interval {
  std::uint64_t first, last;
  bool single() const { return first == last; }
};

/// One cut on its way: it lies among the items of its group in the interval of keys or, once that is a single
/// key, in the interval of numbers.
struct Cut {
  std::uint32_t group;
  std::uint64_t target;     ///< weight of the group that should go left
  std::uint64_t below = 0;  ///< weight left of the intervals
  Interval keys, numbers;
  std::uint64_t items = 0;  ///< in the intervals, of all ranks
  Threshold threshold{kEnd, kEnd};
  bool done = false;

  Interval& active() { return keys.single() ? numbers : keys; }
  Threshold at(std::uint64_t x) const { return keys.single() ? Threshold{keys.first, x} : Threshold{x, 0}; }
  Threshold after(std::uint64_t x) const {
    return keys.single() ? Threshold{keys.first, x + 1} : Threshold{x, kEnd};
  }
};

/// Equal pieces of an interval; the last ones may be empty.
class Bins {
 public:
  Bins(const Interval& whole, std::size_t count)
      : whole_(whole), width_((whole.last - whole.first) / count + 1), count_(count) {}
  std::size_t count() const { return count_; }
  bool empty(std::size_t b) const { return b > (whole_.last - whole_.first) / width_; }
  Interval operator[](std::size_t b) const {
    const std::uint64_t first = whole_.first + b * width_;
    return {first, whole_.last - first < width_ ? whole_.last : first + (width_ - 1)};
  }

 private:
  Interval whole_;
  std::uint64_t width_;
  std::size_t count_;
};

/// This rank's items in order, group after group.
class SortedItems {
 public:
  SortedItems(const OrderedItems& items, std::span<const std::uint32_t> groups, std::size_t num_groups);

  /// Position of the first item of the group that is not before the threshold.
  std::size_t position(std::uint32_t group, const Threshold& t) const;
  std::uint64_t weight(std::size_t begin, std::size_t end) const { return prefix_[end] - prefix_[begin]; }
  std::size_t begin(std::uint32_t group) const { return begins_[group]; }
  std::size_t end(std::uint32_t group) const { return begins_[group + 1]; }
  std::uint64_t key(std::size_t position) const { return keys_[position]; }
  std::uint64_t number(std::size_t position) const { return numbers_[position]; }
  std::uint32_t item(std::size_t position) const { return order_[position]; }

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::uint64_t> keys_, numbers_, prefix_;
  std::vector<std::size_t> begins_;
};

/// Sorted by value, group by group: by index, keys would be fetched from all over memory.
SortedItems::SortedItems(const OrderedItems& items, std::span<const std::uint32_t> groups,
                         std::size_t num_groups)
    : begins_(num_groups + 1, 0) {
  struct Entry {
    std::uint64_t key, number;
    std::uint32_t item;
  };
  for (const std::uint32_t g : groups) ++begins_[g + 1];
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  std::vector<Entry> entries(groups.size());
  std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
  for (std::uint32_t i = 0; i < entries.size(); ++i)
    entries[next[groups[i]]++] = {items.keys[i], items.numbers[i], i};
  for (std::size_t g = 0; g < num_groups; ++g)
    std::sort(
        entries.begin() + static_cast<std::ptrdiff_t>(begins_[g]),
        entries.begin() + static_cast<std::ptrdiff_t>(begins_[g + 1]),
        [](const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : a.number < b.number; });
  prefix_.push_back(0);
  for (const Entry& e : entries) {
    order_.push_back(e.item);
    keys_.push_back(e.key);
    numbers_.push_back(e.number);
    prefix_.push_back(prefix_.back() + items.weights[e.item]);
  }
}

std::size_t SortedItems::position(std::uint32_t group, const Threshold& t) const {
  const auto begin = keys_.begin();
  const auto [first, last] = std::equal_range(begin + begins_[group], begin + begins_[group + 1], t.key);
  const auto found =
      std::lower_bound(numbers_.begin() + (first - begin), numbers_.begin() + (last - begin), t.number);
  return found - numbers_.begin();
}

/// Floor of total * part / whole; part <= whole < 2^32, total < 2^62.
std::uint64_t share_of(std::uint64_t total, std::uint64_t part, std::uint64_t whole) {
  return total / whole * part + total % whole * part / whole;
}

class Cutter {
 public:
  Cutter(Peers& peers, const SortedItems& items, const std::vector<std::vector<std::uint32_t>>& shares,
         std::uint64_t my_greatest_number)
      : peers_(peers), items_(items), shares_(shares) {
    begin(my_greatest_number);
  }

  std::vector<Cut> run() {
    for (;;) {
      std::vector<Cut*> open;
      for (Cut& cut : cuts_)
        if (!cut.done) open.push_back(&cut);
      if (open.empty()) return std::move(cuts_);
      if (are_few(open))
        finish(open);
      else
        round(open);
    }
  }

 private:
  void begin(std::uint64_t my_greatest_number);
  void round(const std::vector<Cut*>& open);
  static bool are_few(const std::vector<Cut*>& open);
  void finish(const std::vector<Cut*>& open);
  void count(const Cut& cut, const Bins& bins, std::uint64_t* weights_and_counts) const;
  static void narrow(Cut& cut, const Bins& bins, const std::uint64_t* weights_and_counts);

  Peers& peers_;
  const SortedItems& items_;
  const std::vector<std::vector<std::uint32_t>>& shares_;
  std::vector<Cut> cuts_;
};

/// All cuts, each with the keys of its whole group.
void Cutter::begin(std::uint64_t my_greatest_number) {
  const auto num_groups = static_cast<std::uint32_t>(shares_.size());
  struct Group {
    std::uint64_t total = 0, items = 0, least = kEnd, greatest = 0, greatest_number = 0;
  };
  std::vector<Group> groups(num_groups);
  for (std::uint32_t g = 0; g < num_groups; ++g) {
    groups[g].total = items_.weight(items_.begin(g), items_.end(g));
    groups[g].items = items_.end(g) - items_.begin(g);
    groups[g].greatest_number = my_greatest_number;
    if (items_.begin(g) == items_.end(g)) continue;
    groups[g].least = items_.key(items_.begin(g));
    groups[g].greatest = items_.key(items_.end(g) - 1);
  }
  groups = reduce(peers_, groups, [](const Group& a, const Group& b) {
    return Group{a.total + b.total, a.items + b.items, std::min(a.least, b.least),
                 std::max(a.greatest, b.greatest), std::max(a.greatest_number, b.greatest_number)};
  });
  for (std::uint32_t g = 0; g < num_groups; ++g) {
    const std::uint64_t whole = std::accumulate(shares_[g].begin(), shares_[g].end(), std::uint64_t{0});
    std::uint64_t part = 0;
    for (std::size_t j = 0; j + 1 < shares_[g].size(); ++j) {
      part += shares_[g][j];
      const Group& group = groups[g];
      Cut cut{g,
              share_of(group.total, part, whole),
              0,
              {group.least, group.greatest},
              {0, group.greatest_number}};
      cut.items = group.items;
      cut.done = group.total == 0;
      cuts_.push_back(cut);
    }
  }
}

void Cutter::round(const std::vector<Cut*>& open) {
  const std::size_t count_of_bins = std::clamp<std::size_t>(kBinsPerRound / open.size(), 8, 1024);
  std::vector<std::uint64_t> histograms(2 * count_of_bins * open.size(), 0);
  std::vector<Bins> bins;
  for (std::size_t i = 0; i < open.size(); ++i) {
    bins.emplace_back(open[i]->active(), count_of_bins);
    count(*open[i], bins[i], &histograms[2 * count_of_bins * i]);
  }
  histograms = partition::sum(peers_, histograms);
  for (std::size_t i = 0; i < open.size(); ++i) narrow(*open[i], bins[i], &histograms[2 * count_of_bins * i]);
}

bool Cutter::are_few(const std::vector<Cut*>& open) {
  const std::uint64_t most = std::max<std::uint64_t>(kFewItems, kFewOfCut * open.size());
  std::uint64_t left = 0;
  for (const Cut* cut : open) left += cut->items;
  return left <= most;
}

/// An item between the ends of a cut.
struct OpenItem {
  std::uint64_t cut, key, number, weight;
};

/// All ranks get all items that are left, and find the cuts among them.
void Cutter::finish(const std::vector<Cut*>& open) {
  std::vector<OpenItem> left;
  for (std::uint64_t c = 0; c < open.size(); ++c) {
    Cut& cut = *open[c];
    const std::size_t begin = items_.position(cut.group, cut.at(cut.active().first));
    const std::size_t end = items_.position(cut.group, cut.after(cut.active().last));
    for (std::size_t p = begin; p < end; ++p)
      left.push_back({c, items_.key(p), items_.number(p), items_.weight(p, p + 1)});
  }
  left = allgather_joined(peers_, left);
  std::ranges::sort(left, {}, [](const OpenItem& c) { return std::tuple(c.cut, c.key, c.number); });
  auto next = left.begin();
  for (std::uint64_t c = 0; c < open.size(); ++c) {
    Cut& cut = *open[c];
    cut.threshold = cut.after(cut.active().last);
    cut.done = true;
    std::uint64_t below = cut.below;
    const auto end = std::find_if(next, left.end(), [&](const OpenItem& item) { return item.cut != c; });
    for (; next != end; below += next++->weight)
      if (2 * below + next->weight > 2 * cut.target) break;
    if (next != end) cut.threshold = {next->key, next->number};
    next = end;
  }
}

void Cutter::count(const Cut& cut, const Bins& bins, std::uint64_t* weights_and_counts) const {
  std::size_t from = items_.position(cut.group, cut.at(bins[0].first));
  for (std::size_t b = 0; b < bins.count() && !bins.empty(b); ++b) {
    const std::size_t to = items_.position(cut.group, cut.after(bins[b].last));
    weights_and_counts[2 * b] = items_.weight(from, to);
    weights_and_counts[2 * b + 1] = to - from;
    from = to;
  }
}

/// Goes into the bin where the cut is, or finds that it is at a bin's end. An item goes left when its middle
/// is not beyond the target: the items' middles ascend, since all weights are positive.
void Cutter::narrow(Cut& cut, const Bins& bins, const std::uint64_t* weights_and_counts) {
  std::size_t b = 0;
  while (b < bins.count() && cut.below + weights_and_counts[2 * b] <= cut.target)
    cut.below += weights_and_counts[2 * b++];
  // Only a target of the whole interval passes all bins; the threshold then is the interval's end.
  cut.done = true;
  if (b == bins.count()) {
    cut.threshold = cut.after(cut.active().last);
    return;
  }
  const std::uint64_t weight = weights_and_counts[2 * b];
  const Interval bin = bins[b];
  if (cut.target <= cut.below) {
    cut.threshold = cut.at(bin.first);
  } else if (weights_and_counts[2 * b + 1] == 1 || (cut.keys.single() && bin.single())) {
    const bool left = 2 * cut.below + weight <= 2 * cut.target;
    cut.threshold = left ? cut.after(bin.last) : cut.at(bin.first);
  } else {
    cut.active() = bin;
    cut.items = weights_and_counts[2 * b + 1];
    cut.done = false;
  }
}

}  // namespace

std::vector<std::uint32_t> cut_groups(Peers& peers, const OrderedItems& items,
                                      std::span<const std::uint32_t> groups,
                                      const std::vector<std::vector<std::uint32_t>>& shares) {
  const SortedItems sorted(items, groups, shares.size());
  std::uint64_t greatest_number = 0;
  for (const std::uint64_t number : items.numbers) greatest_number = std::max(greatest_number, number);
  const std::vector<Cut> cuts = Cutter(peers, sorted, shares, greatest_number).run();

  std::vector<std::uint32_t> parts(items.keys.size());
  std::uint32_t part = 0;
  auto cut = cuts.begin();
  for (std::uint32_t g = 0; g < shares.size(); ++g) {
    std::size_t from = sorted.begin(g);
    for (std::size_t j = 0; j < shares[g].size(); ++j, ++part) {
      const bool last = j + 1 == shares[g].size();
      const std::size_t to = last ? sorted.end(g) : sorted.position(g, (cut++)->threshold);
      for (; from < to; ++from) parts[sorted.item(from)] = part;
    }
  }
  return parts;
}

std::uint64_t ordered_key(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x + 0.0);  // -0 and 0 are one number
  return bits >> 63 ? ~bits : bits | std::uint64_t{1} << 63;
}

std::vector<std::uint64_t> integer_weights(Peers& peers, std::span<const double> work) {
  const auto usable = [](double w) { return w > 0 ? std::min(w, std::numeric_limits<double>::max()) : 0.0; };
  double greatest = 0;
  for (const double w : work) greatest = std::max(greatest, usable(w));
  greatest = partition::max(peers, greatest);
  const auto count = partition::sum(peers, std::uint64_t{work.size()});
  const double units = std::ldexp(1.0, 61 - std::bit_width(count)) - 1;
  std::vector<std::uint64_t> weights(work.size(), 1);
  if (greatest > 0)
    for (std::size_t i = 0; i < work.size(); ++i)
      weights[i] += static_cast<std::uint64_t>(usable(work[i]) / greatest * units);
  return weights;
}

}  // namespace weft::partition
