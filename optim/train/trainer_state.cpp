// Checkpoints: the trainer's state by name.
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <string>
#include <vector>

#include "io/base/state_file.hpp"
#include "optim/train/state.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kIterations = "iterations";  // planned

void need_iterations(const std::string& file, std::span<const std::byte> saved, int iterations) {
  int planned = 0;
  if (saved.size() == sizeof planned) std::memcpy(&planned, saved.data(), sizeof planned);
  if (saved.size() == sizeof planned && planned <= iterations) return;
  throw_input_error(file,
                    kIterations,
                    fmt::format("a training of {}", planned),
                    fmt::format("of {} or fewer: it can be made longer, not shorter", iterations));
}

void add_set(StateList& list, const std::string& name, TrainedSet& set) {
  list.add(name + "/count", set.particles.count);
  list.add(name + "/stride", set.particles.stride);
  list.add(name + "/parameters", set.particles.params);
  list.add(name + "/actors", set.particles.actor_of);
  list.add(name + "/first_moment", set.adam.first_moment());
  list.add(name + "/second_moment", set.adam.second_moment());
  list.add(name + "/steps", set.adam.iteration());
  list.add(name + "/rejections", set.adam.rejections());
  list.add(name + "/errors", set.error);
}

/// What has been learned of the actors' tracks.
void add_tracks(StateList& list, std::vector<Actor>& actors) {
  list.add_numbers(
      "actors/offsets",
      [&actors] {
        std::vector<double> out;
        for (const Actor& actor : actors) {
          for (const KeyPose& key : actor.track) {
            out.insert(out.end(), key.shift_m.begin(), key.shift_m.end());
            out.insert(out.end(), key.turn_rad.begin(), key.turn_rad.end());
          }
        }
        return out;
      },
      [&actors](std::span<const double> numbers) {
        for (Actor& actor : actors) {
          for (KeyPose& key : actor.track) {
            key.shift_m = Eigen::Vector3d(numbers.data());
            key.turn_rad = Eigen::Vector3d(numbers.data() + 3);
            numbers = numbers.subspan(6);
          }
        }
      });
}

}  // namespace

StateList Trainer::state(const std::string& settings) {
  StateList list;
  list.add_fixed(kSettings, settings);
  list.add(
      kIterations,
      [this] {
        StateList::Bytes bytes(sizeof options_.iterations);
        std::memcpy(bytes.data(), &options_.iterations, bytes.size());
        return bytes;
      },
      [this](const std::string& file, std::span<const std::byte> saved) {
        need_iterations(file, saved, options_.iterations);
      });
  list.add("status", status_);
  list.add("mean/squared_error", square_);
  list.add("mean/distance", distance_);
  list.add("mean/right_drops", right_);
  list.add("relocated", relocated_);
  list.add("grown", grown_);
  list.add("unsound_losses", unsound_losses_);
  add_set(list, "camera", camera_);
  add_set(list, "lidar", lidar_);
  add_tracks(list, scene_.actors);
  for (TrainedSet* set : {&camera_, &lidar_}) {
    list.add_numbers(
        set == &camera_ ? "camera/poses" : "lidar/poses",
        [this, set] { return set->poses.numbers(scene_.actors); },
        [this, set](std::span<const double> numbers) { set->poses.set_numbers(scene_.actors, numbers); });
  }
  if (anchor_) {
    list.add("anchor/candidates", anchor_->candidates());
    list.add("anchor/nearest", anchor_->nearest());
  }
  look_.add_state(list);
  for (auto& [name, offset] : offsets_) list.add("offset/" + name, offset);
  return list;
}

void Trainer::save(const std::filesystem::path& file, const std::string& settings) {
  state(settings).write(file);
}

void Trainer::need_settings(const std::filesystem::path& file, const std::string& settings, int iterations) {
  const StateFile state(file);
  StateList::need_text(file.string(), kSettings, state.block(kSettings), settings);
  need_iterations(file.string(), state.block(kIterations), iterations);
}

void Trainer::resume(const std::filesystem::path& file, const std::string& settings) {
  state(settings).read(file);
  for (TrainedSet* set : {&camera_, &lidar_}) {
    set->fit_gradients();
    set->particles.refresh_actors();
  }
}

}  // namespace simuli
