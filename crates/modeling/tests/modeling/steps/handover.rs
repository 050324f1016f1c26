//! What is kept for another database, and what older versions left.

use std::fs;

use super::{PAGES, bytes, interrupted, left, options, site, times_in, updated};
use hedgehop::progress::Silent;
use hedgehop_modeling::{BuildOptions, build, forget_steps, is_kept_for, is_own_work, take_over};

#[test]
fn a_database_keeps_its_steps_under_another_name() {
    let folder = site();
    let name = |name: &str| folder.path().join(name);
    let new = BuildOptions { threads: 1, ..options(folder.path(), "a.hop") };
    let old = BuildOptions { output: name("b.hop"), kept_for: Some(name("a.hop")), ..new.clone() };

    // Of a build of the new name nothing stays, finished or not; of one of the old name neither.
    build(&new, &Silent).unwrap();
    forget_steps(&new.output);
    assert!(interrupted(&new, 20).is_err() && left(folder.path()).len() == 4, "{:?}", left(folder.path()));
    assert!(!is_kept_for(&old.output, &new.output));
    updated(&old);
    assert!(is_kept_for(&old.output, &new.output) && !is_kept_for(&old.output, &name("c.hop")));
    forget_steps(&old.output);
    assert!(is_kept_for(&old.output, &new.output));
    updated(&old);
    assert!(is_kept_for(&old.output, &new.output) && !is_kept_for(&new.output, &old.output));
    take_over(&old.output, &new.output).unwrap();
    assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);
    assert!(!is_kept_for(&old.output, &new.output) && !folder.path().join("b.hop.steps").exists());

    // The log knows the file as it is: to the system a new name is a change of it.
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let (log, file) = (bytes(&folder.path().join("a.hop.steps")), fs::metadata(&new.output).unwrap());
        let changed = i128::from(file.ctime()) * 1_000_000_000 + i128::from(file.ctime_nsec());
        let last = String::from_utf8_lossy(&log[times_in(&log)..]).into_owned();
        assert!(last.contains(&changed.to_string()), "{last}");
    }
    assert_eq!(updated(&new).reused, PAGES);
    // Pages of a build that was never finished are something, too.
    let third = BuildOptions { output: name("c.hop"), kept_for: Some(name("a.hop")), ..new.clone() };
    assert!(interrupted(&third, 20).is_err() && is_kept_for(&third.output, &new.output));
    assert!(!third.output.exists());

    // What a build left that it was not for is its own.
    let other = BuildOptions { output: name("d.hop"), kept_for: None, ..new.clone() };
    updated(&other);
    assert!(is_own_work(&other.output) && !is_kept_for(&other.output, &new.output));
}

#[test]
fn what_an_older_version_built_is_replaced_unasked() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    let mut older = bytes(&options.output);
    // The version follows the magic.
    older[8] -= 1;
    fs::write(&options.output, &older).unwrap();
    assert!(is_own_work(&options.output));
    assert_eq!(updated(&options).reused, 0, "but nothing of it stays");
}
