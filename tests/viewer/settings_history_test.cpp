// Undo and redo of settings and of what was moved.
#include "viewer/settings_history.h"

#include <gtest/gtest.h>

#include "viewer/edit_history.h"

namespace voxcone {
namespace {

Settings withGain(double gain) {
    Settings settings;
    settings.cone.gain = gain;
    return settings;
}

TEST(SettingsHistory, UndoAndRedoAreInverse) {
    SettingsHistory history{Settings{}};
    const double first = history.now().cone.gain;
    history.change(withGain(2), "cone.gain");
    history.change(withGain(3), "cone.gain");
    EXPECT_EQ(history.undoName(), "cone.gain");
    history.undo();
    EXPECT_EQ(history.now().cone.gain, 2);
    history.undo();
    EXPECT_EQ(history.now().cone.gain, first);
    EXPECT_FALSE(history.canUndo());
    history.redo();
    history.redo();
    EXPECT_EQ(history.now().cone.gain, 3);
    EXPECT_FALSE(history.canRedo());
}

TEST(SettingsHistory, ADragIsOneStep) {
    SettingsHistory history{Settings{}};
    const double first = history.now().cone.gain;
    for (int i = 1; i < 20; ++i) history.change(withGain(2 + 0.1 * i), "cone.gain", true);
    history.release();
    history.change(withGain(7), "cone.gain", true);
    history.undo();
    EXPECT_NEAR(history.now().cone.gain, 3.9, 1e-12);
    history.undo();
    EXPECT_EQ(history.now().cone.gain, first);
}

TEST(SettingsHistory, WhatChangesNothingIsNoStep) {
    SettingsHistory history{Settings{}};
    history.change(Settings{}, "reset all");
    EXPECT_FALSE(history.canUndo());
    Settings wide = history.now();
    wide.output.width = 333;
    history.replace(wide);
    EXPECT_FALSE(history.canUndo());
    EXPECT_EQ(history.now().output.width, 333);
}

TEST(EditHistory, MovesAndSettingsAreTakenBackInTheirOrder) {
    SettingsHistory settings;
    EditHistory edits;
    Edits scene;
    scene.lights.resize(1);
    edits.begin(scene);
    edits.commit(scene);
    EXPECT_FALSE(edits.canUndo(settings)) << "nothing has changed";

    const auto move = [&](double x) {
        scene.placed[3].translation = glm::dvec3(x, 0, 0);
        edits.commit(scene);
    };
    Settings changed = settings.now();
    move(1);
    changed.cone.gain = 2;
    settings.change(changed, "cone.gain");
    move(2);
    // Back: the second move, the setting, the first move.
    ASSERT_TRUE(edits.canUndo(settings));
    edits.undo();
    EXPECT_EQ(edits.now().placed.at(3).translation->x, 1);
    EXPECT_FALSE(edits.canUndo(settings));
    settings.undo();
    ASSERT_TRUE(edits.canUndo(settings));
    edits.undo();
    EXPECT_TRUE(edits.now().placed.empty());
    EXPECT_FALSE(edits.canUndo(settings));
    // And forth.
    ASSERT_TRUE(edits.canRedo(settings));
    edits.redo();
    EXPECT_FALSE(edits.canRedo(settings));
    settings.redo();
    ASSERT_TRUE(edits.canRedo(settings));
    edits.redo();
    EXPECT_EQ(edits.now(), scene);
    // A new move ends what could come again.
    edits.undo();
    move(5);
    EXPECT_FALSE(edits.canRedo(settings));
}

TEST(SettingsHistory, EveryFieldIsComparedAndCopied) {
    Settings changed;
    auto all = fields(changed);
    const Settings defaults;
    for (std::size_t i = 0; i < all.size(); ++i) {
        Settings one;
        const Field field = fields(one)[i];
        if (auto* const* flag = std::get_if<bool*>(&field.value)) **flag = !**flag;
        if (auto* const* integer = std::get_if<int*>(&field.value))
            **integer = field.allowed.empty() ? **integer + 1
                                              : (**integer == field.allowed[0] ? field.allowed[1] : field.allowed[0]);
        if (auto* const* number = std::get_if<double*>(&field.value)) **number += 0.01;
        if (const auto* choice = std::get_if<Field::Choice>(&field.value))
            choice->set((choice->get() + 1) % static_cast<int>(choice->names.size()));
        EXPECT_TRUE(fieldDiffers(one, defaults, i)) << field.key;
        EXPECT_FALSE(sameSettings(one, defaults)) << field.key;
        EXPECT_EQ(fieldIndex(field.key), i);
        Settings copy;
        copyField(one, copy, i);
        EXPECT_TRUE(sameSettings(one, copy)) << field.key;
    }
}

}  // namespace
}  // namespace voxcone
