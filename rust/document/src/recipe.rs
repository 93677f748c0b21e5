//! Recipes: what things on the layers were made of, so that these can be changed later, as a sticker whose pins are moved.
//!
//! A document knows a recipe by its number and its bytes; what they mean is for their writers. Edits change recipes
//! as they change blocks, and undo puts them back.

use relievo_core::{Error, Result};

use crate::edit::Direction;

/// Recipes a document may have.
pub const MAX_RECIPES: usize = 1 << 16;
/// Bytes a recipe may have.
pub const MAX_RECIPE: usize = 4 << 20;

/// What something on the layers was made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// Its number, which no other recipe of the document has.
    pub id: u32,
    /// What it says.
    pub bytes: Vec<u8>,
}

/// A recipe that an edit changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecipeChange {
    /// Its number.
    pub id: u32,
    /// Its bytes before and after, if it was there and is there.
    pub states: [Option<Vec<u8>>; 2],
}

/// Puts the recipe `id` into a list that ascends by number, in place of the one that is there, or removes it without
/// bytes.
///
/// # Errors
/// It has more than [`MAX_RECIPE`] bytes, or there are [`MAX_RECIPES`].
pub fn put(recipes: &mut Vec<Recipe>, id: u32, bytes: Option<Vec<u8>>) -> Result<()> {
    let place = recipes.binary_search_by_key(&id, |recipe| recipe.id);
    if bytes.as_ref().is_some_and(|bytes| bytes.len() > MAX_RECIPE) {
        return Err(Error::invalid(format!("a recipe has more than {MAX_RECIPE} bytes")).advise("make it smaller"));
    }
    match (place, bytes) {
        (Ok(at), Some(bytes)) => recipes[at].bytes = bytes,
        (Ok(at), None) => drop(recipes.remove(at)),
        (Err(_), Some(_)) if recipes.len() == MAX_RECIPES => {
            return Err(Error::invalid(format!("a document has at most {MAX_RECIPES} recipes")).advise("remove some"));
        }
        (Err(at), Some(bytes)) => recipes.insert(at, Recipe { id, bytes }),
        (Err(_), None) => {}
    }
    Ok(())
}

/// Returns what changes one list into another; both ascend by number.
pub fn difference(before: &[Recipe], after: &[Recipe]) -> Vec<RecipeChange> {
    let find = |list: &[Recipe], id: u32| {
        let at = list.binary_search_by_key(&id, |recipe| recipe.id).ok()?;
        Some(list[at].bytes.clone())
    };
    let mut numbers: Vec<u32> = before.iter().chain(after).map(|recipe| recipe.id).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let changes = numbers.into_iter().map(|id| RecipeChange { id, states: [before, after].map(|list| find(list, id)) });
    changes.filter(|change| change.states[0] != change.states[1]).collect()
}

/// Takes changes in a direction.
///
/// # Errors
/// As [`put`].
pub fn go(recipes: &mut Vec<Recipe>, changes: &[RecipeChange], direction: Direction) -> Result<()> {
    changes.iter().try_for_each(|change| put(recipes, change.id, change.states[1 - direction as usize].clone()))
}
