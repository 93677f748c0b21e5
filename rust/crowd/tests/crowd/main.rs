//! Crowds, by closed forms, invariants, an evaluator of their own and hostile files.

mod agents;
mod arm;
mod cuts;
mod deformation;
mod device;
mod device_poses;
mod draws;
mod errors;
mod export;
mod files;
mod geomorph;
mod hostile;
mod impostors;
mod morphs;
mod occlusion;
mod refit;
mod seams;
mod sharing;
mod skinning;
mod streams;
mod views;
mod weights;
