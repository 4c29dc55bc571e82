//! The command line as a person meets it.

mod blind_check;
mod command_line;
mod effect_removed;
mod killed;
mod malformed;
mod meals;
mod new_user;
mod next_step;
mod other_plants;
mod outputs;
mod own_effect;
mod people_in_use;
mod pipeline;
mod population;
mod posterior;
mod results;
mod training;
mod tutorial;
