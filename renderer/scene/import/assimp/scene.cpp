#include "scene/import/assimp/scene.h"

#include "scene/import/assimp/file_system.h"
#include "scene/import/assimp/parts.h"
#include "scene/import/assimp/smooth_normals.h"
#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"
#include "scene/mesh_builder.h"
#include "scene/srgb.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

constexpr float kCreaseDegrees = 45.0f;  // sharper edges stay sharp in generated normals
constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_GenSmoothNormals |
                            aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                            aiProcess_ValidateDataStructure | aiProcess_FlipUVs;

// Removes all other readers: Assimp would choose one by the file's content.
void keepOnlyReader(Assimp::Importer& importer, const std::string& extension) {
    const Assimp::BaseImporter* selected = importer.GetImporter(extension.c_str());
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        Assimp::BaseImporter* reader = importer.GetImporter(i);
        if (reader && reader != selected) {
            importer.UnregisterLoader(reader);
            delete reader;  // owned by the caller after it was unregistered
        }
    }
    if (!selected) {
        throw ImportError(Reason::unsupported, "there is no reader for ." + extension);
    }
}

glm::dvec3 vector(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

// A frame at `position` whose -Z looks along `direction`.
glm::dmat4 frameAlong(const glm::dvec3& position, glm::dvec3 direction, glm::dvec3 up) {
    const double length = glm::length(direction);
    direction = length > 0.0 && std::isfinite(length) ? direction / length : glm::dvec3(0, 0, -1);
    glm::dvec3 right = glm::cross(direction, up);
    if (!(glm::length(right) > 1e-9)) {  // up along the view
        up = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
        right = glm::cross(direction, up);
    }
    right = glm::normalize(right);
    glm::dmat4 frame(1.0);
    frame[0] = glm::dvec4(right, 0.0);
    frame[1] = glm::dvec4(glm::cross(right, direction), 0.0);
    frame[2] = glm::dvec4(-direction, 0.0);
    frame[3] = glm::dvec4(position, 1.0);
    return frame;
}

// FBX has a unit in centimetres, which Assimp does not apply. Assimp applies the unit of COLLADA;
// the other formats have none.
double metresPerUnit(const aiScene& file) {
    float centimetres = 100.0f;
    const bool present = file.mMetaData && file.mMetaData->Get("UnitScaleFactor", centimetres);
    const bool valid = present && centimetres > 1e-6f && centimetres < 1e6f;
    return valid ? static_cast<double>(centimetres) / 100.0 : 1.0;
}

glm::dmat4 scaled(const glm::dmat4& matrix, double factor) {
    glm::dmat4 scale(factor);
    scale[3][3] = 1.0;
    return scale * matrix;
}

// Some files have all their normals on the side from which their triangles are clockwise.
void alignNormals(MeshDraft& draft) {
    std::int64_t agreeing = 0;
    for (std::size_t i = 0; i + 2 < draft.indices.size(); i += 3) {
        const Vertex &a = draft.vertices[draft.indices[i]],
                     &b = draft.vertices[draft.indices[i + 1]],
                     &c = draft.vertices[draft.indices[i + 2]];
        const float cosine = glm::dot(glm::cross(b.position - a.position, c.position - a.position),
                                      a.normal + b.normal + c.normal);
        agreeing += (cosine > 0.0f) - (cosine < 0.0f);
    }
    if (agreeing >= 0) return;
    for (Vertex& v : draft.vertices) v.normal = -v.normal;
}

// PLY without faces: every vertex is a point.
bool isPointCloud(const aiMesh& mesh) {
    return mesh.mNumFaces == 0 && mesh.mPrimitiveTypes == aiPrimitiveType_POINT;
}

Primitive primitiveOf(const aiMesh& mesh) {
    return mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE ? Primitive::triangles
           : mesh.mPrimitiveTypes & aiPrimitiveType_LINE   ? Primitive::lines
                                                           : Primitive::points;
}

// Assimp gives lines and points next to triangles normals that are no numbers.
bool hasNormals(const aiMesh& mesh) {
    if (!mesh.HasNormals() || primitiveOf(mesh) == Primitive::triangles) return mesh.HasNormals();
    return std::any_of(mesh.mNormals, mesh.mNormals + mesh.mNumVertices, [](const aiVector3D& n) {
        return std::isfinite(n.x) && n.SquareLength() > 0.0f;
    });
}

class AssimpReader {
public:
    AssimpReader(const aiScene& file, const std::string& extension, const ImportLimits& limits)
        : file_(file),
          colorsAreSrgb_(extension == "ply" || extension == "obj"),
          metresPerUnit_(metresPerUnit(file)),
          limits_(limits) {}

    Scene run(const std::string& extension, const SceneFolder& folder,
              const ProgressCallback& progress) {
        TextureStore textures(folder, limits_);
        AssimpMaterials materials(file_, extension, folder, textures, scene_);
        materials.read();
        readNodes();
        animations_.readClips();
        for (unsigned i = 0; i < file_.mNumMeshes; ++i) {
            meshes_.push_back(add(*file_.mMeshes[i]));
        }
        materials.setGlassThickness();
        addInstances();
        finishMotion(scene_);
        readCameras();
        readLights();
        textures.finish(scene_, progress);
        return std::move(scene_);
    }

private:
    Index add(const aiMesh& from) {
        MeshDraft draft;
        draft.name = from.mName.C_Str();
        draft.material = from.mMaterialIndex;
        draft.primitive = primitiveOf(from);
        draft.hasNormals = hasNormals(from);
        const std::uint32_t each = indicesPer(draft.primitive);
        const bool cloud = isPointCloud(from);
        countPrimitives(primitives_, cloud ? from.mNumVertices : from.mNumFaces, limits_);
        draft.hasTexCoords = from.HasTextureCoords(0);
        draft.vertices.resize(from.mNumVertices);
        for (unsigned i = 0; i < from.mNumVertices; ++i) {
            Vertex& v = draft.vertices[i];
            v.position = glm::vec3(vector(from.mVertices[i]));
            if (draft.hasNormals) v.normal = glm::vec3(vector(from.mNormals[i]));
            if (draft.hasTexCoords) {
                v.texCoord0 = {from.mTextureCoords[0][i].x, from.mTextureCoords[0][i].y};
            }
            if (from.HasTextureCoords(1)) {
                v.texCoord1 = {from.mTextureCoords[1][i].x, from.mTextureCoords[1][i].y};
            }
            if (from.HasVertexColors(0)) {
                v.color = color(from.mColors[0][i]);
            }
        }
        draft.indices.reserve(std::size_t{each} * from.mNumFaces);
        for (unsigned f = 0; f < from.mNumFaces; ++f) {
            const aiFace& face = from.mFaces[f];
            if (face.mNumIndices == each) {
                draft.indices.insert(draft.indices.end(), face.mIndices, face.mIndices + each);
            }
        }
        for (unsigned i = 0; cloud && i < from.mNumVertices; ++i) draft.indices.push_back(i);
        if (draft.hasNormals && each == 3) alignNormals(draft);
        if (!animations_.moves(from)) return addMesh(scene_, std::move(draft));
        draft.deforms = true;
        std::vector<std::uint32_t> sources;
        const Index mesh = addMesh(scene_, std::move(draft), sources);
        if (mesh != kNone) animations_.addDeformation(from, sources);
        return mesh;
    }

    // Vertex colours are sRGB in OBJ and PLY, linear in other formats.
    glm::vec4 color(const aiColor4D& c) const {
        return colorsAreSrgb_
                   ? glm::vec4(linearFromSrgb(c.r), linearFromSrgb(c.g), linearFromSrgb(c.b), c.a)
                   : glm::vec4(c.r, c.g, c.b, c.a);
    }

    // Depth first without recursion.
    void readNodes() {
        std::vector<std::pair<const aiNode*, Index>> pending{{file_.mRootNode, kNone}};
        while (!pending.empty()) {
            const auto [from, parent] = pending.back();
            pending.pop_back();
            glm::dmat4 local = matrixOf(from->mTransformation);
            if (parent == kNone) {
                local = scaled(local, metresPerUnit_);
            }
            if (!inReach(local)) {
                scene_.warnings.push_back({"nonFiniteTransform", from->mName.C_Str(),
                                           "a transform with non-finite numbers was ignored"});
                local = glm::dmat4(1.0);
            }
            const Index node = addCheckedNode(from->mName.C_Str(), local, parent);
            nodeNamed_.try_emplace(from->mName.C_Str(), node);
            for (unsigned i = 0; i < from->mNumMeshes; ++i) {
                meshAt_.emplace_back(node, from->mMeshes[i]);
            }
            if (meshAt_.size() > 4 * limits_.maxNodes) {
                throw ImportError(Reason::limit, "the scene has too many instances");
            }
            for (unsigned i = from->mNumChildren; i-- > 0;) {
                pending.emplace_back(from->mChildren[i], node);
            }
        }
    }

    // An animated skinned mesh is placed by its bones and not by its node. One whose bones are not
    // animated is drawn at its node in its bind pose.
    void addInstances() {
        for (const auto& [node, number] : meshAt_) {
            const Index mesh = meshes_.at(number);
            if (mesh == kNone) continue;
            const Index deformation = scene_.meshes[mesh].deformation;
            Index parent = node;
            if (deformation != kNone) {
                const Skin& skin = scene_.skins[scene_.deformations[deformation].skin];
                const glm::dvec3 origin = skinOrigin(scene_, skin.joints.front());
                parent = addCheckedNode(scene_.nodes[node].name + " (skinned)",
                                        glm::translate(glm::dmat4(1.0), origin), kNone);
            }
            addInstance(scene_, parent, mesh);
        }
    }

    Index addCheckedNode(const std::string& name, const glm::dmat4& local, Index parent) {
        if (scene_.nodes.size() >= limits_.maxNodes) {
            throw ImportError(Reason::limit, "the scene has more than " +
                                                 std::to_string(limits_.maxNodes) + " nodes");
        }
        return addNode(scene_, name, local, parent);
    }

    // A node for a camera or a light, which Assimp attaches to another node by name.
    Index frameNode(const aiString& name, const aiVector3D& position, const aiVector3D& direction,
                    const aiVector3D& up) {
        const auto parent = nodeNamed_.find(name.C_Str());
        glm::dmat4 frame = frameAlong(vector(position), vector(direction), vector(up));
        return addCheckedNode(name.C_Str(), inReach(frame) ? frame : glm::dmat4(1.0),
                              parent == nodeNamed_.end() ? kNone : parent->second);
    }

    // The clipping planes of these formats are mostly defaults; ours are fitted to the scene.
    void readCameras() {
        for (unsigned i = 0; i < file_.mNumCameras; ++i) {
            const aiCamera& from = *file_.mCameras[i];
            Camera camera;
            camera.name = from.mName.C_Str();
            camera.orthographic = from.mOrthographicWidth > 0.0f;
            const double aspect = from.mAspect > 0.0f ? static_cast<double>(from.mAspect) : 1.0;
            const double half = static_cast<double>(from.mHorizontalFOV) / 2.0;
            camera.yfov = 2.0 * std::atan(std::tan(half) / aspect);
            camera.yHalfHeight = static_cast<double>(from.mOrthographicWidth) / aspect;
            const bool valid = camera.orthographic
                                   ? std::isfinite(camera.yHalfHeight) && camera.yHalfHeight > 0.0
                                   : camera.yfov > 0.0 && camera.yfov < std::numbers::pi;
            if (!valid) {
                scene_.warnings.push_back(
                    {"badCamera", camera.name, "a camera with an empty view was ignored"});
                continue;
            }
            camera.yfov = camera.orthographic ? Camera{}.yfov : camera.yfov;
            camera.yHalfHeight = camera.orthographic ? camera.yHalfHeight : 1.0;
            camera.node = frameNode(from.mName, from.mPosition, from.mLookAt, from.mUp);
            scene_.cameras.push_back(camera);
        }
    }

    void readLights() {
        for (unsigned i = 0; i < file_.mNumLights; ++i) {
            const aiLight& from = *file_.mLights[i];
            if (from.mType == aiLightSource_AMBIENT || from.mType == aiLightSource_UNDEFINED) {
                scene_.warnings.push_back(
                    {"unsupportedLight", from.mName.C_Str(),
                     "an ambient light was ignored; the environment map lights the scene"});
                continue;
            }
            Light light;
            light.name = from.mName.C_Str();
            light.kind = from.mType == aiLightSource_DIRECTIONAL ? LightKind::directional
                         : from.mType == aiLightSource_SPOT      ? LightKind::spot
                                                                 : LightKind::point;
            const aiColor3D& c = from.mColorDiffuse;
            const glm::dvec3 intensity = intensityPerColor(from) * glm::dvec3(c.r, c.g, c.b);
            constexpr double kMaxIntensity = 1e9;  // keeps products finite in float
            for (int k = 0; k < 3; ++k) {
                const bool valid = std::isfinite(intensity[k]);
                light.intensity[k] =
                    static_cast<float>(valid ? std::clamp(intensity[k], 0.0, kMaxIntensity) : 0.0);
            }
            if (light.kind == LightKind::spot) {  // Assimp has full angles
                light.outerConeAngle = halfCone(from.mAngleOuterCone);
                light.innerConeAngle =
                    std::min(halfCone(from.mAngleInnerCone), light.outerConeAngle);
            }
            light.node = frameNode(from.mName, from.mPosition, from.mDirection, from.mUp);
            scene_.lights.push_back(light);
        }
    }

    // These formats specify the brightness of a white surface that faces the light, and its
    // falloff; glTF specifies intensity. The two are equal at half the scene's diagonal (everywhere
    // for a quadratic falloff): intensity = pi * colour * d^2 / attenuation(d). A colour far above
    // white is a power in watts, as Blender exports it to FBX.
    double intensityPerColor(const aiLight& light) const {
        constexpr double kPi = std::numbers::pi;
        constexpr float kMinWatts = 10.0f;
        const aiColor3D& color = light.mColorDiffuse;
        if (light.mType == aiLightSource_DIRECTIONAL) {
            return kPi;
        }
        if (std::max({color.r, color.g, color.b}) > kMinWatts) {
            return 1.0 / (4.0 * kPi);
        }
        const auto diagonal = static_cast<double>(worldBounds(scene_, restPose(scene_)).diagonal());
        const double metres = diagonal > 0.0 && std::isfinite(diagonal) ? diagonal / 2.0 : 1.0;
        const double units = metres / metresPerUnit_;
        const double attenuation = light.mAttenuationConstant + light.mAttenuationLinear * units +
                                   light.mAttenuationQuadratic * units * units;
        return kPi * metres * metres / (attenuation > 0.0 ? attenuation : 1.0);
    }

    static float halfCone(float whole) {
        constexpr float kNarrowest = 1e-3f, kWidest = 1.57079f;
        return std::isfinite(whole) ? std::clamp(whole / 2.0f, kNarrowest, kWidest)
                                    : Light{}.outerConeAngle;
    }

    const aiScene& file_;
    bool colorsAreSrgb_;
    double metresPerUnit_;
    ImportLimits limits_;
    Scene scene_;
    std::vector<Index> meshes_;
    std::vector<std::pair<Index, unsigned>> meshAt_;  // node, and the file's mesh at it
    std::map<std::string, Index> nodeNamed_;
    AssimpAnimations animations_{file_, scene_, nodeNamed_, metresPerUnit_};
    std::uint64_t primitives_ = 0;
};

}  // namespace

Scene assimpScene(const std::string& file, const std::string& extension, const SceneFolder& folder,
                  const ImportLimits& limits, const ProgressCallback& progress) {
    Assimp::Importer importer;
    keepOnlyReader(importer, extension);
    importer.SetIOHandler(new AssimpFileSystem(folder));  // the importer deletes it
    importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kCreaseDegrees);
    // Assimp must not create meshes that depict the nodes of a file without meshes.
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    const aiScene* scene = importer.ReadFile(file, extension == "ply" ? 0 : kSteps);
    // The steps refuse meshes without faces.
    const bool cloud = scene && scene->mNumMeshes == 1 && isPointCloud(*scene->mMeshes[0]);
    if (extension == "ply" && scene && !cloud) {
        for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
            addSmoothNormals(*scene->mMeshes[i], kCreaseDegrees);
        }
        scene = importer.ApplyPostProcessing(kSteps);
    }
    if (!scene || !scene->mRootNode) {
        const std::string message = importer.GetErrorString();
        if (message.find("bad_alloc") != std::string::npos) {
            throw std::bad_alloc();
        }
        throw ImportError(Reason::malformed,
                          message.empty() ? "the file has no scene" : cleanText(message));
    }
    if (progress) {
        progress({"meshes", 0.2});
    }
    return AssimpReader(*scene, extension, limits).run(extension, folder, progress);
}

}  // namespace clerestory
