//! Loops over all threads.
//!
//! Each takes the items of any iterator and calls a closure for every one of them, on whichever thread is free. The loop
//! itself is compiled once, over closures behind a pointer, where an iterator of rayon is compiled anew at each place that
//! uses it, thousands of lines before optimisation. What it costs is a lock and a call an item, some 20 ns: items are rows,
//! bands of texels or photographs, not texels.
//!
//! Results stand in the order of the items, and of several errors the one of the first item is given, so that neither depends
//! on the threads.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use crate::error::{Error, Result};

/// Values that [`for_each_value`] takes together.
const TOGETHER: usize = 1 << 12;

/// What waits for the thread that takes it, or was left by it.
type Handover<T> = Mutex<Option<T>>;

/// Calls `work` for each item.
pub(crate) fn for_each<I: Send>(items: impl IntoIterator<Item = I>, work: impl Fn(I) + Sync) {
    let items = filled(items);
    run(items.len(), &|place| work(taken(&items[place])));
}

/// Calls `work` for each item, and not for those behind one that failed.
///
/// # Errors
/// The error of the first item that failed.
pub(crate) fn try_for_each<I: Send>(
    items: impl IntoIterator<Item = I>,
    work: impl Fn(I) -> Result<()> + Sync,
) -> Result<()> {
    let items = filled(items);
    try_run(items.len(), &|place| work(taken(&items[place])))
}

/// What `of` makes of each item.
pub(crate) fn map<I: Send, T: Send>(
    items: impl IntoIterator<Item = I>,
    of: impl Fn(I) -> T + Sync,
) -> Vec<T> {
    let items = filled(items);
    let made = empty(items.len());
    run(items.len(), &|place| put(&made[place], of(taken(&items[place]))));
    all(made)
}

/// What `of` makes of each item.
///
/// # Errors
/// The error of the first item that failed.
pub(crate) fn try_map<I: Send, T: Send>(
    items: impl IntoIterator<Item = I>,
    of: impl Fn(I) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let items = filled(items);
    let made = empty(items.len());
    try_run(items.len(), &|place| {
        put(&made[place], of(taken(&items[place]))?);
        Ok(())
    })?;
    Ok(all(made))
}

/// Calls `work` for each of many values that are not worth a lock each, with its place.
pub(crate) fn for_each_value<T: Send>(values: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    for_each(values.chunks_mut(TOGETHER).enumerate(), |(part, values)| {
        (part * TOGETHER..).zip(values).for_each(|(place, value)| work(place, value));
    });
}

/// Room that items need while they are worked on, made when there is none and used again by later items.
pub(crate) struct Spares<S, F> {
    idle: Mutex<Vec<S>>,
    make: F,
}

/// Room of one item, given back when this is dropped. It holds what an earlier item left in it.
pub(crate) struct Spare<'a, S> {
    room: Option<S>,
    idle: &'a Mutex<Vec<S>>,
}

impl<S, F: Fn() -> S> Spares<S, F> {
    /// Room that `make` makes.
    pub(crate) fn new(make: F) -> Self {
        Self { idle: Mutex::new(Vec::new()), make }
    }

    /// Room that no other thread has.
    pub(crate) fn take(&self) -> Spare<'_, S> {
        let idle = locked(&self.idle).pop();
        Spare { room: Some(idle.unwrap_or_else(&self.make)), idle: &self.idle }
    }
}

impl<S> Deref for Spare<'_, S> {
    type Target = S;

    fn deref(&self) -> &S {
        self.room.as_ref().expect("there until it is dropped")
    }
}

impl<S> DerefMut for Spare<'_, S> {
    fn deref_mut(&mut self) -> &mut S {
        self.room.as_mut().expect("there until it is dropped")
    }
}

impl<S> Drop for Spare<'_, S> {
    fn drop(&mut self) {
        locked(self.idle).extend(self.room.take());
    }
}

/// Calls `work` with each place below `count`: the one loop behind all others.
#[inline(never)]
fn run(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

/// As [`run`], until a place fails. Places before the first that failed are all worked on.
fn try_run(count: usize, work: &(dyn Fn(usize) -> Result<()> + Sync)) -> Result<()> {
    let end = AtomicUsize::new(count);
    let first: Handover<Error> = Mutex::new(None);
    run(count, &|place| {
        if place < end.load(Ordering::Relaxed)
            && let Err(error) = work(place)
        {
            let mut first = locked(&first);
            if place < end.load(Ordering::Relaxed) {
                end.store(place, Ordering::Relaxed);
                *first = Some(error);
            }
        }
    });
    first.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}

fn filled<T>(items: impl IntoIterator<Item = T>) -> Vec<Handover<T>> {
    items.into_iter().map(|item| Mutex::new(Some(item))).collect()
}

fn empty<T>(count: usize) -> Vec<Handover<T>> {
    (0..count).map(|_| Mutex::new(None)).collect()
}

fn taken<T>(slot: &Handover<T>) -> T {
    locked(slot).take().expect("each place is worked on once")
}

fn put<T>(slot: &Handover<T>, value: T) {
    *locked(slot) = Some(value);
}

fn all<T>(slots: Vec<Handover<T>>) -> Vec<T> {
    let value = |slot: Handover<T>| slot.into_inner().unwrap_or_else(PoisonError::into_inner);
    slots.into_iter().map(|slot| value(slot).expect("each place was worked on")).collect()
}

/// A panic of another thread ends the loop anyway, so what it left is not looked at.
fn locked<T>(slot: &Mutex<T>) -> MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    #[test]
    fn every_item_is_worked_on_once_and_results_keep_their_order() {
        let mut values = vec![0; 1000];
        for_each(values.chunks_mut(7).enumerate(), |(i, chunk)| chunk.iter_mut().for_each(|v| *v += i));
        assert!(values.iter().enumerate().all(|(i, &v)| v == i / 7));
        assert_eq!(map(0..1000, |i| 3 * i), (0..1000).map(|i| 3 * i).collect::<Vec<_>>());
        assert!(map(0..0, |i: usize| i).is_empty());
    }

    #[test]
    fn of_several_errors_the_first_is_given() {
        let odd = |i: usize| match i {
            300 | 301 | 900 => Err(Error::invalid(format!("{i}"))),
            _ => Ok(i),
        };
        for _ in 0..50 {
            let error = try_map(0..1000, odd).unwrap_err();
            assert_eq!((error.kind(), error.to_string().contains("300")), (ErrorKind::Invalid, true));
            assert!(try_for_each(0..1000, |i| odd(i).map(drop)).unwrap_err().to_string().contains("300"));
        }
        assert_eq!(try_map(0..300, odd).unwrap().len(), 300);
    }

    #[test]
    fn scratch_is_never_shared() {
        let scratch = Spares::new(|| 0_usize);
        let twice = map(0..1000, |i| {
            let mut value = scratch.take();
            *value = i;
            std::thread::yield_now();
            *value + i
        });
        assert!(twice.iter().enumerate().all(|(i, &v)| v == 2 * i));
    }
}
