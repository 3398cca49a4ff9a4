// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/camera_frame.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/lab/synth/depth_sensor.hpp"
#include "core/lab/synth/ray_caster.hpp"
#include "core/lab/synth/stereo_sensor.hpp"
#include "core/lab/synth/time_of_flight_sensor.hpp"

namespace segserve::synth {

Picture render(const World& world, const Camera& camera, const Lighting& lighting, const ShadowMap& shadow) {
  const RayCaster caster(world, camera);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  Picture picture;
  picture.depth = {camera.width, camera.height, std::vector<double>(pixels), std::vector<float>(pixels),
                   std::vector<std::uint32_t>(pixels)};
  picture.color.resize(pixels);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
      const Hit hit = caster.cast(u, v);
      if (!hit.exists()) continue;
      const Surface surface = caster.surface(u, v, hit);
      const Vec3 ray = unit(camera.pose.rotate_to_parent(camera.ray(u, v)));
      const double lit = shadow.lit_share(caster.world_point(u, v, hit.depth), surface.normal);
      picture.color[i] = lighting.shade(color_at(world[hit.solid].texture, surface), surface.normal, lit);
      picture.depth.depth[i] = hit.depth;
      picture.depth.incidence[i] = static_cast<float>(std::abs(dot(ray, surface.normal)));
      picture.depth.label[i] = world[hit.solid].label;
    }
  }
  return picture;
}

void measure_depth(Sensor sensor, double focal, double noise, bool holes, Picture& picture, Random& random) {
  switch (sensor) {
    case Sensor::kKinect1:
      return DepthSensor{.focal = focal, .noise = noise, .holes = holes}.measure(picture.depth, random);
    case Sensor::kStereo:
    case Sensor::kPassiveStereo: {
      const bool projector = sensor == Sensor::kStereo;
      const StereoSensor stereo{.focal = focal, .noise = noise, .holes = holes, .projector = projector};
      return stereo.measure(picture.color, picture.depth, random);
    }
    case Sensor::kTimeOfFlight: {
      const TimeOfFlightSensor time_of_flight{.focal = focal, .noise = noise, .holes = holes};
      return time_of_flight.measure(picture.color, picture.depth, random);
    }
    case Sensor::kIdeal:
      return;
  }
}

SyntheticScene to_cloud(const Camera& camera, const DepthImage& image, std::vector<std::uint32_t> rgb) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  SyntheticScene scene;
  Cloud& cloud = scene.cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  cloud.view = View::camera();
  cloud.x.assign(image.depth.size(), kNaN);
  cloud.y = cloud.z = cloud.x;
  cloud.rgb = std::move(rgb);
  scene.label = image.label;
  scene.camera = codec::Intrinsics{camera.focal, camera.focal, camera.center_u, camera.center_v};
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      const double z = image.depth[i];
      if (z == 0) {
        scene.label[i] = 0;
        continue;
      }
      const Vec3 point = z * camera.ray(u, v);
      cloud.x[i] = static_cast<float>(point.x);
      cloud.y[i] = static_cast<float>(point.y);
      cloud.z[i] = static_cast<float>(point.z);
    }
  }
  return scene;
}

}  // namespace segserve::synth
