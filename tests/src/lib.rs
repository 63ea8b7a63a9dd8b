//! Scenes, reference data, claims and charts: the proof of the workspace.
