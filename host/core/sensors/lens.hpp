#pragma once
// The map between directions and the picture, without focal length and principal point. Frame: OpenCV (x right,
// y down, z forward). Image coordinates (u, v) are in focal lengths from the principal point.
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

namespace shared {
template <class real>
struct LensConstants;
}

/// Numbered as SIM_LENS_.. of cl/shared/sensor_constants.h.
enum class LensKind : int {
  kPinhole = 0,          // ideal
  kOpencvPinhole = 1,    // rational radial, tangential and thin-prism distortion
  kOpencvFisheye = 2,    // Kannala-Brandt: radius = t + k1 t^3 + .. + k4 t^9
  kFtheta = 3,           // radius = a1 t + .. + a5 t^5, then [[c d] [e 1]]
  kFthetaInverse = 4,    // t = b1 radius + .. + b5 radius^5, then [[c d] [e 1]]
  kMei = 5,              // unified mirror model with radial-tangential distortion
  kEquirectangular = 6,  // (azimuth, elevation): a full turn about the y axis
  kDoubleSphere = 7,
  kEucm = 8,  // extended unified model
};

/// Returns the file names "pinhole", "opencv_pinhole", ..., in the order of LensKind.
[[nodiscard]] const std::vector<std::string>& lens_names();
[[nodiscard]] const char* to_string(LensKind kind);
/// Throws Error{kInput} with `file` and `field` for an unknown name.
[[nodiscard]] LensKind lens_from_string(const std::string& name,
                                        const std::string& file,
                                        const std::string& field);
/// Returns the names of a kind's parameters with units, in order: "k1", ..., "max_angle_rad".
[[nodiscard]] const std::vector<std::string>& lens_parameter_names(LensKind kind);

/// Glass in front of a lens that bends rays (NCore's bivariate windshield): for a unit ray direction (x, y, z),
/// asin(x) and asin(y) are replaced by polynomials of both. P(a, b) = sum_j (sum_i c_ij a^i) b^j with i + j up
/// to the degree, coefficients ordered by j, then by i: 1, 3, 6, 10, 15 or 21 of them for the degrees 0 to 5.
struct Windshield {
  /// The direction whose polynomials are exact; the others approximate the inverse, as start of a search.
  enum class Reference { kForward, kBackward };
  Reference reference = Reference::kForward;
  std::vector<double> horizontal, vertical;                  // from the world to the lens
  std::vector<double> horizontal_inverse, vertical_inverse;  // from the lens to the world
  bool operator==(const Windshield&) const = default;
};

/// A lens, immutable after construction: its parameters and the domain in which its map is injective. The
/// domain ends at max_angle_rad (pi: only the polynomials' limit) or at the first fold of the distortion,
/// whichever is smaller; points and pixels beyond it have no image and no ray.
class Lens {
 public:
  /// The ideal pinhole. Projects points up to 84 degrees off axis (z >= a tenth of the distance); beyond,
  /// images diverge, and only rays are defined.
  Lens();
  /// `parameters` in the order of lens_parameter_names(kind). Throws Error{kInput} with `file` and the
  /// parameter for a wrong number or an invalid value.
  Lens(LensKind kind, const std::vector<double>& parameters, const std::string& file = "lens");

  /// Returns this lens behind `glass`, replacing another windshield; an ideal pinhole becomes an OpenCV pinhole
  /// without distortion. Throws Error{kInput} with `file` and the polynomial for wrong numbers of coefficients,
  /// non-finite values, a map that is not injective about the axis, and an equirectangular lens.
  [[nodiscard]] Lens behind(const Windshield& glass, const std::string& file = "lens") const;

  [[nodiscard]] LensKind kind() const { return kind_; }
  /// Rays outside the domain in which a windshield's polynomials are injective have no image.
  [[nodiscard]] const std::optional<Windshield>& windshield() const { return windshield_; }
  [[nodiscard]] const std::vector<double>& parameters() const { return parameters_; }
  /// Constants for the device: cl/shared/sensor_constants.h.
  [[nodiscard]] const shared::LensConstants<double>& constants() const { return *constants_; }

  /// Image of a point (m); false without one. Same text as on the device (cl/math/camera.h).
  [[nodiscard]] bool project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const;
  /// Evaluates the formula also past the first fold, where points have no image: a bound of one is a bound of
  /// the other. False where it is not smooth.
  [[nodiscard]] bool continued(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const;
  /// Returns the unit direction of this image; zero without one. The result is verified by projection.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& image) const;
  /// Focal lengths per rad at the axis.
  [[nodiscard]] double centre_slope() const;

  /// These three determine all other members.
  bool operator==(const Lens& other) const {
    return kind_ == other.kind_ && parameters_ == other.parameters_ && windshield_ == other.windshield_;
  }

 private:
  bool forward(const Eigen::Vector3d& p_camera, Eigen::Vector2d& image) const;  // returns whether it has an image
  /// Applies the windshield, if any; false where no ray passes.
  bool bend(const Eigen::Vector3d& p_camera, Eigen::Vector3d& bent) const;
  void fill_constants();
  void find_domain(double max_angle_rad);
  void find_bent_domain(const std::string& file);  // lens/windshield.cpp, as unbend() and behind()
  [[nodiscard]] Eigen::Vector3d inverse(const Eigen::Vector2d& image) const;  // of the lens itself
  [[nodiscard]] Eigen::Vector3d unbend(const Eigen::Vector3d& bent) const;

  LensKind kind_ = LensKind::kPinhole;
  std::vector<double> parameters_;
  std::optional<Windshield> windshield_;
  std::shared_ptr<shared::LensConstants<double>>
      constants_;  // shared by copies; complete after construction
};

}  // namespace simuli
