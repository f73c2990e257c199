#include "viewer/presenter.h"

#include "gl/bindings.h"

namespace voxcone {

std::shared_ptr<const gl::Texture> Presenter::encode(const gl::Texture& picture, bool smooth) {
    auto out = std::make_shared<gl::Texture>(gl::Texture::create2D(GL_RGBA8, picture.width(), picture.height()));
    out->filter(GL_LINEAR, smooth ? GL_LINEAR : GL_NEAREST);
    picture.bindTo(gl::kPassTextureUnit);
    program_.set("u_picture", gl::kPassTextureUnit);
    out->bindImage(0, 0, GL_WRITE_ONLY);
    program_.set("u_encoded", 0);
    gl::dispatch(program_, gl::groupsFor(out->width(), 8), gl::groupsFor(out->height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    glFinish();
    return out;
}

std::shared_ptr<const gl::Texture> Presenter::encode(const Image& picture, bool smooth) {
    std::vector<float> texels(static_cast<std::size_t>(4 * picture.width * picture.height));
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const float* from = picture.pixel(x, y);
            float* to = &texels[4 * (static_cast<std::size_t>(picture.height - 1 - y) *
                                         static_cast<std::size_t>(picture.width) +
                                     static_cast<std::size_t>(x))];
            for (int c = 0; c < 3; ++c) to[c] = from[picture.channels >= 3 ? c : 0];
            to[3] = 1;
        }
    }
    gl::Texture linear = gl::Texture::create2D(GL_RGBA32F, picture.width, picture.height);
    linear.upload(0, GL_RGBA, GL_FLOAT, texels.data());
    return encode(linear, smooth);
}

}  // namespace voxcone
