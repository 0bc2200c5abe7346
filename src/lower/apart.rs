//! Which known values may move at the same time without being confused: those of which no list of dependencies has two (Curtis, Powell, Reid
//! 1974). So many derivatives are found at once, and their number no longer grows with the square of the model.

use std::collections::{BTreeMap, HashSet};

/// Groups of places of which no list has two.
pub(super) fn apart<'a>(lists: impl IntoIterator<Item = &'a [usize]>) -> Vec<Vec<usize>> {
    let lists: HashSet<&[usize]> = lists.into_iter().collect();
    let mut holders: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, list) in lists.iter().enumerate() {
        list.iter().for_each(|&place| holders.entry(place).or_default().push(index));
    }
    let mut taken: Vec<Vec<u64>> = vec![Vec::new(); lists.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, holders) in holders {
        let group = first_free(&taken, &holders);
        if group == groups.len() {
            groups.push(Vec::new());
        }
        groups[group].push(place);
        for holder in holders {
            let taken = &mut taken[holder];
            taken.resize(taken.len().max(group / 64 + 1), 0);
            taken[group / 64] |= 1 << (group % 64);
        }
    }
    groups
}

/// The first group of which none of these lists has a place yet; each list has its groups as bits.
fn first_free(taken: &[Vec<u64>], holders: &[usize]) -> usize {
    let word = |index: usize| holders.iter().fold(0, |all, &list| all | taken[list].get(index).copied().unwrap_or(0));
    let mut index = 0;
    loop {
        let free = word(index).trailing_ones();
        if free < u64::BITS {
            return 64 * index + free as usize;
        }
        index += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shares_no_list_moves_together() {
        let groups = apart([[0, 1, 2].as_slice(), &[3, 4], &[2, 3], &[]]);
        assert_eq!(groups, [vec![0, 3], vec![1, 4], vec![2]]);
    }

    #[test]
    fn long_lists_and_many_short_ones_need_as_many_groups_as_the_longest() {
        let lists: Vec<Vec<usize>> = (0..50).map(|list| (150 * list..150 * (list + 1)).collect()).collect();
        let groups = apart(lists.iter().map(Vec::as_slice));
        assert_eq!(groups.len(), 150);
        assert!(groups.iter().all(|group| group.len() == 50));
    }
}
